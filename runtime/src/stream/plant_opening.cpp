#include "plant_opening.h"

namespace coppice {

Result<std::unique_ptr<PlantOpening>> start_opening(const Hooks& hooks, const GpuSizes& gpu, const char* path, std::uint32_t index) {
  std::unique_ptr<PlantOpening> opening(new (std::nothrow) PlantOpening);
  if (!opening) return Error{Status::out_of_memory, "plant"};
  COPPICE_TRY(plant, open_plant_file(hooks, gpu, path, index));
  opening->plant = std::move(plant);
  opening->reads.start(hooks.io, opening->plant->io_file, 0, opening->header);
  return opening;
}

bool repeat_reads(PlantOpening& opening, std::uint64_t (*clock_ns)()) {
  if (opening.reads.whole()) {
    opening.retry = {};
    return false;
  }
  if (opening.retry.again_ns == 0) return opening.retry.pause(clock_ns());
  if (clock_ns() < opening.retry.again_ns) return true;
  opening.retry.again_ns = 0;
  opening.reads.repeat_failed(opening.plant->hooks.io, opening.plant->io_file);
  return true;
}

Result<void> take_header(PlantOpening& opening) {
  COPPICE_CHECK(opening.reads.take());
  COPPICE_TRY(header, read_header(opening.header, opening.plant->file_bytes));
  opening.plant->file.header = header;
  return {};
}

Result<void> start_front(PlantOpening& opening) {
  const PlantStream& plant = *opening.plant;
  COPPICE_CHECK(allocate_into(opening.front, plant.hooks.allocator, static_cast<std::size_t>(plant.file.header.first_read_bytes)));
  opening.step = PlantOpening::Step::front;
  opening.reads.start(plant.hooks.io, plant.io_file, 0, opening.front.span());
  return {};
}

Result<void> take_front(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  COPPICE_CHECK(opening.reads.take());
  return take_front(plant, opening.front.span());
}

void start_texture_headers(PlantOpening& opening) {
  PlantStream& plant = *opening.plant;
  opening.step = PlantOpening::Step::textures;
  if (plant.gpu.block_textures) return;
  opening.texture_headers.reserve(plant.texture_uploads.size());
  for (std::uint32_t i = 0; i < plant.texture_uploads.size(); ++i) {
    const coppice_file_chunk& entry = plant.file_chunk(plant.chunk(ChunkKind::texture, i));
    if (entry.bytes < sizeof(coppice_file_texture)) continue;
    PlantOpening::TextureHeader& header = opening.texture_headers.emplace_back();
    header.texture = i;
    opening.reads.start(plant.hooks.io, plant.io_file, entry.offset, header.bytes);
  }
}

Result<void> take_texture_headers(PlantOpening& opening) {
  COPPICE_CHECK(opening.reads.take());
  for (const PlantOpening::TextureHeader& header : opening.texture_headers)
    take_texture_header(*opening.plant, header.texture, header.bytes);
  measure_leaf_meshes(*opening.plant);
  opening.step = PlantOpening::Step::read;
  return {};
}

}  // namespace coppice
