#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace coppice {

/// A queue that brings back finished jobs and reads to one collecting thread, in order of completion. An Item has a member `Item* next` for
/// the queue, and does not move from expect() until it is taken. push: any thread; the rest: the collecting thread.
template <class Item>
class CompletionQueue {
 public:
  /// Announces that `count` items go to a hook; each comes back through push.
  void expect(std::uint32_t count = 1) {
    const std::lock_guard lock(mutex_);
    expected_ += count;
  }
  // Notifies under the lock: the waiter may destroy the queue as soon as it can take it.
  void push(Item* item) {
    const std::lock_guard lock(mutex_);
    item->next = nullptr;
    (last_ != nullptr ? last_->next : first_) = item;
    last_ = item;
    if (--expected_ == 0) all_back_.notify_all();
  }
  /// Returns the item that finished first; null if there is none.
  Item* take() {
    const std::lock_guard lock(mutex_);
    Item* item = first_;
    if (item != nullptr) first_ = item->next;
    if (first_ == nullptr) last_ = nullptr;
    return item;
  }
  /// True if every expected item has been pushed.
  [[nodiscard]] bool all_back() const {
    const std::lock_guard lock(mutex_);
    return expected_ == 0;
  }
  void wait_for_all() const {
    std::unique_lock lock(mutex_);
    all_back_.wait(lock, [this] { return expected_ == 0; });
  }

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable all_back_;
  Item* first_ = nullptr;
  Item* last_ = nullptr;
  std::uint32_t expected_ = 0;
};

}  // namespace coppice
