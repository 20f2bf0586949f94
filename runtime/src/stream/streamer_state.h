#pragma once

// The streamer's internals, in streamer.cpp (the interface), streamer_frame.cpp (progress of transfers, requests), streamer_budget.cpp
// (counting and evicting) and streamer_threshold.cpp (demand and thresholds).

#include <algorithm>
#include <cstdint>
#include <memory>

#include "bounded_list.h"
#include "plant_opening.h"
#include "plant_stream.h"
#include "streamer.h"

namespace coppice {

/// A list for the GPU side with a fixed capacity: filled between calls, handed out once.
template <class T>
struct HandOut {
  HookArray<T> items;
  std::size_t count = 0;
  bool handed_out = false;

  /// Drops elements that were handed out; the others stay for the next call.
  void begin() {
    if (handed_out) count = 0;
    handed_out = false;
  }
  [[nodiscard]] bool full() const { return count == items.size(); }
  void add(const T& item) { items[count++] = item; }
  std::span<const T> take() {
    if (handed_out) return {};
    handed_out = true;
    return {items.data(), count};
  }
};

/// A chunk that may be requested, or uploaded.
struct Request {
  PlantStream* plant = nullptr;
  Chunk* chunk = nullptr;
  float value = 0.0f;
};

/// A strict order, by value.
bool has_lower_priority(const Request& a, const Request& b);

/// Chunks that are loaded all or not at all.
struct Indivisible {
  Chunk* chunk = nullptr;  ///< a texture, or one leaf mesh chunk of the plant for all of them
  bool* affordable = nullptr;
  std::uint64_t bytes = 0;
  float value = 0.0f;
};

/// Whether memory is available for a request.
enum class Room : std::uint8_t {
  now,
  soon,  ///< once the GPU is done with evicted chunks, or a cancelled read returns
  none,  ///< all memory holds chunks in demand
};

struct Streamer::State {
  State(const Hooks& of, Ledger& shared_ledger, const StreamerOptions& with) : hooks(of), ledger(shared_ledger), options(with) {}

  Hooks hooks;
  Ledger& ledger;
  StreamerOptions options;
  DecoderPool decoders;
  HookArray<std::unique_ptr<PlantStream>> plants;     ///< grows to max_plants; null: not open
  HookArray<std::unique_ptr<PlantOpening>> openings;  ///< [plant]
  std::uint32_t plant_end = 0;                        ///< plants from here on were never open
  std::uint32_t first_free_plant = 0;                 ///< those before are in use
  std::size_t started_count = 0;                      ///< openings that are not queued
  HookArray<Transfer> transfers;                      ///< [max_in_flight]
  CompletionQueue<Transfer> completions;              ///< also those that no frame has had time for yet
  std::uint64_t hand_over_until = 0;                  ///< on the clock; when the frame's time for them ends
  BoundedList<Request> requests;  ///< scratch, a heap by value: at most a page, the wood LoDs, textures and leaf meshes of each plant
  BoundedList<Indivisible> indivisible;  ///< scratch of a frame: at most the textures of each plant, and its leaf meshes

  GroupViews views;          ///< with their own thresholds
  bool device_lost = false;  ///< true once it has been logged
  bool all_affordable = true;
  std::uint32_t threshold_step = 0;  ///< number of steps by which the thresholds in use are above the views' own
  bool threshold_falls = false;      ///< threshold_step has just fallen, and may fall further
  std::uint64_t frame_number = 0, last_frame_number = 0, completed_number = 0;

  std::uint64_t movable_bytes = 0;    ///< bytes of chunks that are not pinned
  std::uint64_t evicting_bytes = 0;   ///< bytes that are free once the GPU is done with them
  std::uint64_t cancelled_bytes = 0;  ///< bytes that are free once cancelled reads return
  Chunk* first_evicting = nullptr;    ///< in order of eviction
  Chunk* last_evicting = nullptr;

  HandOut<ChunkId> evicted;
  BoundedList<ChunkId> released;
  HandOut<std::uint32_t> closed;
  HookArray<DecodedChunk> decoded;
  StreamStats counters;

  /// All plants up to the last one that was ever open.
  [[nodiscard]] std::span<const std::unique_ptr<PlantStream>> used_plants() const { return plants.span().first(plant_end); }
  [[nodiscard]] std::span<std::unique_ptr<PlantStream>> used_plants() { return plants.span().first(plant_end); }
  [[nodiscard]] std::span<std::unique_ptr<PlantOpening>> used_openings() { return openings.span().first(plant_end); }

  [[nodiscard]] ChunkCounts& counts_of(const Chunk& chunk) { return counters.chunks[static_cast<std::size_t>(chunk.id.kind)]; }

  // In streamer_budget.cpp:
  /// device_bytes: the part that is in device memory
  void set_bytes(Chunk& chunk, std::uint64_t bytes, std::uint64_t device_bytes = 0);
  /// Bytes that may be reserved in all: the budget minus the bytes refused lately (if they can be freed at all), but at least minus
  /// slack_bytes.
  [[nodiscard]] std::uint64_t limit_bytes() const;
  /// True if they would be free without every chunk that may be evicted.
  [[nodiscard]] bool can_be_free(std::uint64_t bytes) const { return floor_bytes() + bytes <= ledger.budget(); }
  [[nodiscard]] Error refusal(std::uint64_t bytes) const;
  /// Bytes that no eviction frees: the open plants' tables and pinned chunks, and what other modules have reserved.
  [[nodiscard]] std::uint64_t floor_bytes() const;
  /// Tells whether `bytes` more fit. If not, starts to evict chunks without demand, provided that the bytes then fit.
  Room make_room(std::uint64_t bytes);
  /// Cancels and evicts, lowest value first, until the budget is kept.
  void enforce_budget();
  void evict(Chunk& chunk);
  void release_evicted();
  /// Which chunks are candidates. idle: without demand in the last frames; any: all that are not pinned.
  enum class EvictionCandidates : std::uint8_t { idle, any };
  static bool may_evict(const PlantStream& plant, const Chunk& chunk, EvictionCandidates candidates);
  /// Idle chunks come before those in demand, lower values before higher ones.
  Chunk* least_valuable_candidate(EvictionCandidates candidates);
  /// Bytes of idle chunks that can be evicted, in however many frames.
  [[nodiscard]] std::uint64_t idle_bytes() const;
  float value_of(PlantStream& plant, Chunk& chunk);

  // In streamer_threshold.cpp:
  [[nodiscard]] bool has_view() const;
  [[nodiscard]] GroupViews views_at(std::uint32_t step) const;
  /// Memory that the demand at a step needs.
  [[nodiscard]] std::uint64_t planned_bytes_at(std::uint32_t step) const;
  /// Memory that is available for it.
  [[nodiscard]] std::uint64_t room_bytes() const;
  void gather_indivisible();
  /// Decides which textures and leaf meshes may be requested. room: bytes, here and below
  void choose_indivisible(std::uint64_t room);
  void choose_threshold(std::uint64_t room);
  void update_demanded();

  // In streamer_frame.cpp:
  /// Takes over finished transfers until the frame's time for it is up, but at least `least` of them.
  void collect_in_time(std::uint32_t minimum);
  void collect(std::uint32_t minimum);
  void finish_read(Transfer& transfer);
  /// Handles a read that did not give all its bytes: it is retried, or the chunk has failed.
  void fail_read(Transfer& transfer);
  /// Restarts reads whose pause is over.
  void retry_reads();
  void finish_decode(Transfer& transfer);
  void start_page_runs(PlantStream& plant);
  void drop(Transfer& transfer);
  void fail(Transfer& transfer, const Error& error);
  void free_transfer(Transfer& transfer);
  void out_of_memory(PlantStream& plant, const Error& error);
  void trim(PlantStream& plant);
  bool stale(const Transfer& transfer) const;
  void gather_requests();
  void push_page_request(PlantStream& plant);
  void push_request(PlantStream& plant, Chunk& chunk);
  void issue_requests();
  /// Starts a read only if it returns Room::now. Also returns none if the allocator hook had no memory.
  Room issue(const Request& request);
  Transfer* free_slot();

  // In streamer.cpp:
  Result<std::uint32_t> start(const PlantSource& source, bool blocking);
  /// Continues as far as finished work allows. True if the plant is open. errors  io, bad_file, unsupported, out_of_memory
  Result<bool> advance_opening(PlantOpening& opening);
  /// Reserves memory for the pinned chunks. errors  out_of_memory
  Result<void> reserve_pinned(PlantOpening& opening);
  /// The pinned chunks are decoded: the plant is open now.
  void take_opened(PlantOpening& opening);
  void drop_opening(std::uint32_t plant);
  /// Lets the plant's index be used again.
  void free_index(std::uint32_t plant) { first_free_plant = std::min(first_free_plant, plant); }
  /// Reserves arrays for twice as many plants. errors  out_of_memory; nothing has changed
  Result<void> grow_plants();
  /// errors  out_of_memory, as refusal
  Result<void> reserve_for(PlantOpening& opening, std::uint64_t bytes);
  void release(PlantOpening& opening);
  /// Reserves scratch lists for the open plants and one more. errors  out_of_memory
  Result<void> make_list_room(const PlantStream& plant);
  [[nodiscard]] PlantOpening& opening_at(std::uint32_t plant) const;
  void advance_closing(PlantStream& plant);
  void finish_closing();
  PlantStream& open_plant_at(std::uint32_t plant) const;
};

}  // namespace coppice
