#include "plant_opening.h"

#include <algorithm>
#include <utility>

#include "check.h"

namespace coppice {

void PlantOpening::wait() {
  read.wait();
  decoded.wait_for_all();
}

void PlantOpening::clear_pinned() {
  while (decoded.take() != nullptr) continue;
  pinned.reset();
}

void PlantOpening::restart(std::uint64_t frame) {
  step = Step::queued;
  start_frame = frame;
  clear_pinned();
  front = {};
  retry = {};
  plant.reset();
}

Result<void> start_header(PlantOpening& opening, const Hooks& hooks, const GpuSizes& gpu) {
  COPPICE_CHECK(move_into(opening.plant, open_plant_file(hooks, gpu, opening.source, opening.index)));
  opening.step = PlantOpening::Step::header;
  opening.read.start(opening.plant->hooks.io, opening.plant->io_file, 0, opening.header);
  return {};
}

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

Result<void> take_header(PlantOpening& opening) {
  COPPICE_CHECK(opening.read.result());
  return move_into(opening.plant->file.header, read_header(opening.header, opening.plant->file_bytes));
}

Result<void> start_front(PlantOpening& opening) {
  const PlantStream& plant = *opening.plant;
  COPPICE_CHECK(allocate_into(opening.front, plant.hooks.allocator, static_cast<std::size_t>(plant.file.header.first_read_bytes)));
  opening.step = PlantOpening::Step::front;
  opening.read.start(plant.hooks.io, plant.io_file, 0, opening.front.span());
  return {};
}

Result<void> take_front(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  COPPICE_CHECK(opening.read.result());
  return take_front(plant, opening.front.span());
}

namespace {

constexpr coppice_jobs kInline{sizeof(coppice_jobs), nullptr,
                               [](void*, void (*function)(void* argument), void* argument) { function(argument); }};

/// Prepares a pinned chunk of the front for a job.
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

}  // namespace

Result<void> start_pinned(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  opening.step = PlantOpening::Step::decoding;
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
  if (!opening.pinned.empty()) start_decode(opening.pinned[0], opening.blocking ? kInline : plant.hooks.jobs);
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

}  // namespace coppice
