#include "job_order.h"

#include <new>
#include <utility>

namespace coppice {

coppice_job make_job(coppice_job_kind kind, coppice_priority priority, void (*function)(void* argument), void* argument) {
  return {sizeof(coppice_job), kind, priority, 0, function, argument};
}

JobOrder::JobOrder(const coppice_jobs& hook, const coppice_allocator& allocator, std::uint64_t (*clock_ns)())
    : hook_(hook), allocator_(allocator), clock_ns_(clock_ns), last_begin_ns_(clock_ns()) {}

coppice_jobs JobOrder::hook() {
  return {sizeof(coppice_jobs), this, [](void* user, const coppice_job* job) { static_cast<JobOrder*>(user)->submit(*job); }};
}

bool JobOrder::may_begin() const {
  return waiting_count_ == 0 || clock_ns_() - last_begin_ns_ >= kMaxHeldNs;
}

void JobOrder::hold(Task* task) {
  Task** place = &held_;
  while (*place != nullptr && (*place)->number < task->number) place = &(*place)->next;
  task->next = std::exchange(*place, task);
}

JobOrder::Task* JobOrder::take_held() {
  Task* task = held_;
  if (task != nullptr) held_ = task->next;
  return task;
}

void JobOrder::submit(const coppice_job& job) {
  void* memory = allocator_.allocate(allocator_.user, sizeof(Task), alignof(Task));
  if (memory == nullptr) return hook_.submit(hook_.user, &job);
  auto* task = new (memory) Task{this, job};
  {
    const std::lock_guard lock(mutex_);
    task->number = submitted_count_++;
    if (job.kind != COPPICE_JOB_PIPELINE)
      ++waiting_count_;
    else if (!may_begin())
      return hold(task);
  }
  submit(task);
}

void JobOrder::submit(Task* task) {
  const coppice_job job = make_job(task->job.kind, task->job.priority, run, task);
  hook_.submit(hook_.user, &job);
}

// What it releases goes to the hook before the job's own work, so that idle threads of the pool begin with it.
void JobOrder::run(void* argument) {
  auto* task = static_cast<Task*>(argument);
  JobOrder& order = *task->order;
  Task* released = nullptr;
  {
    const std::lock_guard lock(order.mutex_);
    if (task->job.kind == COPPICE_JOB_PIPELINE) {
      if (!order.may_begin()) return order.hold(task);
      order.last_begin_ns_ = order.clock_ns_();
    } else if (--order.waiting_count_ == 0) {
      released = std::exchange(order.held_, nullptr);
    }
  }
  while (released != nullptr) {
    Task* next = released->next;
    order.submit(released);
    released = next;
  }
  const coppice_job job = task->job;
  order.allocator_.free(order.allocator_.user, task, sizeof(Task));
  job.function(job.argument);
}

void JobOrder::release_overdue() {
  Task* task = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (may_begin()) task = take_held();
  }
  if (task != nullptr) submit(task);
}

}  // namespace coppice
