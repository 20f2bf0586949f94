#include "plant_opening.h"

#include <algorithm>
#include <utility>

#include "check.h"
#include "plant_tables.h"
#include "threshold.h"

namespace coppice {

namespace {

using Step = PlantOpening::Step;

constexpr coppice_jobs kInline{sizeof(coppice_jobs), nullptr, [](void*, const coppice_job* job) { job->function(job->argument); }};

void release(PlantOpening& opening, Budget& budget) {
  budget.ledger.release(std::exchange(opening.reserved_bytes, 0));
}

// Memory is reserved before anything is read or decoded. If there is none, begin_frame frees some: the GPU may still read what is evicted
// now.
Result<void> reserve(PlantOpening& opening, Budget& budget, const PlantSet& plants, std::uint64_t more_bytes) {
  const std::uint64_t all_bytes = opening.reserved_bytes + more_bytes;
  release(opening, budget);
  if (!budget.ledger.fits(all_bytes)) return refusal(budget, plants, all_bytes);
  budget.ledger.reserve(all_bytes);
  opening.reserved_bytes = all_bytes;
  return {};
}

/// Bytes of the plant's places in the lists of requests, which grow by half.
std::uint64_t list_bytes(const PlantStream& plant) {
  return max_requests(plant) * (sizeof(ValuedChunk) + sizeof(Lump)) * 3 / 2;
}

/// Bytes of the pinned chunks while they are decoded.
std::uint64_t pinned_bytes(const PlantStream& plant) {
  std::uint64_t bytes = plant.gpu.slack_bytes + gpu::place_plant_tables(plant.file).bytes;
  for (const Chunk& chunk : plant.chunks.span())
    if (chunk.pinned) bytes += chunk_bytes(plant, chunk).total();
  return bytes;
}

/// True if the read of the step has failed and is retried, at once or after a pause.
bool repeat_read(PlantOpening& opening, std::uint64_t (*clock_ns)()) {
  if (opening.read.whole()) {
    opening.retry = {};
    return false;
  }
  if (opening.retry.again_ns == 0) return opening.retry.pause(clock_ns());
  if (clock_ns() < opening.retry.again_ns) return true;
  opening.retry.again_ns = 0;
  opening.read.repeat(opening.plant->hooks.io, opening.plant->io_file);
  return true;
}

Result<void> start_header(PlantOpening& opening, const Openings& openings, const GpuSizes& gpu) {
  COPPICE_CHECK(move_into(opening.plant, open_plant_file(openings.hooks, gpu, opening.source, opening.index)));
  opening.step = Step::header;
  opening.read.start(opening.plant->hooks.io, opening.plant->io_file, 0, opening.header);
  return {};
}

Result<void> take_header(PlantOpening& opening) {
  COPPICE_CHECK(opening.read.result());
  return move_into(opening.plant->file.header, read_header(opening.header, opening.plant->file_bytes));
}

Result<void> start_front(PlantOpening& opening) {
  const PlantStream& plant = *opening.plant;
  COPPICE_CHECK(allocate_into(opening.front, plant.hooks.allocator, static_cast<std::size_t>(plant.file.header.first_read_bytes)));
  opening.step = Step::front;
  opening.read.start(plant.hooks.io, plant.io_file, 0, opening.front.span());
  return {};
}

/// Prepares a pinned chunk of the front for a job. errors  bad_file: the front does not hold it; out_of_memory
Result<void> prepare_pinned(PlantOpening& opening, Chunk& chunk, Transfer& transfer) {
  PlantStream& plant = *opening.plant;
  const coppice_file_chunk& entry = plant.file_chunk(chunk);
  const std::span<const std::uint8_t> front = opening.front.span();
  if (entry.offset > front.size() || entry.bytes > front.size() - entry.offset)
    return Error{Status::bad_file, "first_read_bytes: does not hold the root page and the coarsest wood", entry.offset};
  transfer.queue = &opening.decoded;
  transfer.plant = &plant;
  transfer.chunk = &chunk;
  COPPICE_CHECK(allocate_into(transfer.bytes, plant.hooks.allocator, static_cast<std::size_t>(entry.bytes)));
  std::ranges::copy(front.subspan(static_cast<std::size_t>(entry.offset), transfer.bytes.size()), transfer.bytes.data());
  for (const Residency step : {Residency::reading, Residency::decoding}) COPPICE_ASSERT(advance(chunk, step));
  return chunk.id.kind == ChunkKind::page ? prepare_page(plant, transfer) : Result<void>();
}

Result<void> start_pinned(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  opening.step = Step::decoding;
  COPPICE_CHECK(allocate_into(opening.pinned, plant.hooks.allocator,
                              static_cast<std::size_t>(std::ranges::count(plant.chunks.span(), true, &Chunk::pinned))));
  Transfer* next = opening.pinned.data();
  for (Chunk& chunk : plant.chunks.span()) {
    if (!chunk.pinned) continue;
    if (auto prepared = prepare_pinned(opening, chunk, *next++); !prepared) {
      opening.pinned.reset();
      return prepared;
    }
  }
  for (std::size_t i = 1; i < opening.pinned.size(); ++i) opening.pinned[i - 1].next_in_run = &opening.pinned[i];
  if (!opening.pinned.empty()) start_decode(opening.pinned[0], opening.blocking ? kInline : plant.hooks.jobs, COPPICE_PRIORITY_HIGH);
  return {};
}

Result<void> take_pinned(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  for (Transfer& transfer : opening.pinned) {
    COPPICE_CHECK(transfer.outcome);
    accept_decoded(plant, transfer);
    COPPICE_ASSERT(advance(*transfer.chunk, Residency::decoded));
    if (transfer.chunk->id.kind == ChunkKind::page) plant.decoded_page_count = 1;
  }
  take_coarse_wood(plant);
  return {};
}

}  // namespace

void PlantOpening::wait() {
  read.wait();
  decoded.wait_for_all();
}

void PlantOpening::cancel() {
  cancelled = true;
  if (plant) read.cancel(plant->hooks.io, plant->io_file);
}

Result<bool> advance_opening(Openings& openings, PlantOpening& opening, Budget& budget, const PlantSet& plants, const CurrentFrame& frame) {
  while (opening.idle()) {
    if (opening.step != Step::queued && opening.step != Step::decoding && repeat_read(opening, openings.clock_ns)) return false;
    switch (opening.step) {
      case Step::queued: {
        const bool must_wait = frame.number < opening.start_frame || openings.started_count >= Streamer::kMaxOpening;
        if (!opening.blocking && must_wait) return false;
        COPPICE_CHECK(start_header(opening, openings, budget.gpu));
        opening.plant->decoders = &openings.decoders;
        ++openings.started_count;
        break;
      }
      case Step::header:
        COPPICE_CHECK(take_header(opening));
        COPPICE_CHECK(reserve(opening, budget, plants, opening.plant->file.header.first_read_bytes));
        COPPICE_CHECK(start_front(opening));
        break;
      case Step::front:
        COPPICE_CHECK(opening.read.result());
        COPPICE_CHECK(take_front(*opening.plant, opening.front.span()));
        opening.plant->base_bytes += list_bytes(*opening.plant);
        COPPICE_CHECK(reserve(opening, budget, plants, opening.plant->base_bytes));
        opening.step = Step::read;
        break;
      case Step::read:
        COPPICE_CHECK(reserve(opening, budget, plants, pinned_bytes(*opening.plant)));
        COPPICE_CHECK(start_pinned(opening));
        break;
      case Step::decoding:
        COPPICE_CHECK(take_pinned(opening));
        return true;
    }
  }
  return false;
}

std::unique_ptr<PlantStream> take_opened(PlantOpening& opening, Budget& budget) {
  PlantStream& plant = *opening.plant;
  release(opening, budget);
  budget.ledger.reserve(plant.base_bytes);
  for (Chunk& chunk : plant.chunks.span()) {
    const ChunkBytes bytes = chunk_bytes(plant, chunk);
    if (chunk.pinned) set_bytes(budget, chunk, bytes.gpu + bytes.kept + bytes.upload);
  }
  return std::move(opening.plant);
}

void restart_opening(Openings& openings, PlantOpening& opening, Budget& budget, std::uint64_t start_frame) {
  release(opening, budget);
  if (opening.step != Step::queued) --openings.started_count;
  opening.step = Step::queued;
  opening.start_frame = start_frame;
  while (opening.decoded.take() != nullptr) continue;
  opening.pinned.reset();
  opening.front = {};
  opening.retry = {};
  opening.plant.reset();
}

void drop_opening(Openings& openings, std::uint32_t plant, Budget& budget, const PlantSet& plants) {
  std::unique_ptr<PlantOpening>& opening = openings.all[plant];
  release(*opening, budget);
  if (opening->step != Step::queued) --openings.started_count;
  opening.reset();
  if (plants.all[plant] == nullptr) openings.first_free = std::min(openings.first_free, plant);
}

void drop_cancelled(Openings& openings, Budget& budget, const PlantSet& plants) {
  for (std::uint32_t plant = 0; plant < plants.end; ++plant)
    if (const auto& opening = openings.all[plant]; opening && opening->cancelled && opening->idle())
      drop_opening(openings, plant, budget, plants);
}

}  // namespace coppice
