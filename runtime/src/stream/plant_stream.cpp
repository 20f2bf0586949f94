#include "plant_stream.h"

#include <algorithm>
#include <array>
#include <limits>
#include <new>

#include "block_texture.h"
#include "card_looks.h"
#include "check.h"
#include "convert.h"

namespace coppice {

namespace {

constexpr std::uint32_t kWantWindowFrames = 8;

template <class T>
std::uint64_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

/// Which chunk of ours a chunk of the file is; false: one the streamer does not load by itself.
bool streamed_chunk(const coppice_file_chunk& entry, ChunkKind& kind) {
  if (entry.kind == COPPICE_CHUNK_PAGE) kind = ChunkKind::page;
  if (entry.kind == COPPICE_CHUNK_WOOD) kind = ChunkKind::wood;
  if (entry.kind == COPPICE_CHUNK_TEXTURE) kind = ChunkKind::texture;
  if (entry.kind == COPPICE_CHUNK_LEAF_MESH) kind = ChunkKind::leaf_mesh;
  return entry.kind == COPPICE_CHUNK_PAGE || entry.kind == COPPICE_CHUNK_WOOD || entry.kind == COPPICE_CHUNK_TEXTURE ||
         entry.kind == COPPICE_CHUNK_LEAF_MESH;
}

Result<void> allocate_arrays(PlantStream& plant) {
  const coppice_file_plant& counts = plant.file.plant;
  const coppice_allocator& allocator = plant.hooks.allocator;
  COPPICE_CHECK(allocate_into(plant.chunks, allocator,
                              std::size_t{counts.page_count} + counts.wood_lod_count + counts.texture_count + counts.leaf_mesh_count));
  COPPICE_CHECK(allocate_into(plant.pages, allocator, counts.page_count));
  COPPICE_CHECK(allocate_into(plant.page_nodes, allocator, counts.page_count));
  COPPICE_CHECK(allocate_into(plant.wood, allocator, counts.wood_lod_count));
  COPPICE_CHECK(allocate_into(plant.textures, allocator, counts.texture_count));
  COPPICE_CHECK(allocate_into(plant.leaf_meshes, allocator, counts.leaf_mesh_count));
  return allocate_into(plant.texture_uploads, allocator, counts.texture_count);
}

/// Finds every chunk in the file's table, which the reader has checked: each is there once.
void index_chunks(PlantStream& plant) {
  const coppice_file_plant& counts = plant.file.plant;
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < plant.file.chunks.size(); ++i) {
    const coppice_file_chunk& entry = plant.file.chunks[i];
    ChunkKind kind{};
    if (!streamed_chunk(entry, kind)) continue;
    Chunk& chunk = plant.chunk(kind, entry.index);
    chunk.id = {plant.index, kind, entry.index};
    chunk.file_chunk = i;
    ++found;
  }
  COPPICE_ASSERT(found == plant.chunks.size());
  if (counts.page_count > 0) plant.chunk(ChunkKind::page, 0).pinned = true;
  if (counts.wood_lod_count > 0) plant.chunk(ChunkKind::wood, counts.wood_lod_count - 1).pinned = true;
}

/// A texture is for leaf meshes only if every material that shows it is.
void mark_leaf_mesh_textures(PlantStream& plant) {
  for (const bool only : {true, false})
    for (const coppice_file_material& material : plant.file.materials)
      for (const std::uint32_t texture : {material_texture(material), material_normal_map(material)})
        if (texture != COPPICE_NO_TEXTURE && ((material.flags & COPPICE_MATERIAL_LEAF_MESH_ONLY) != 0) == only)
          plant.texture_uploads[texture].leaf_mesh_only = only;
}

void fill_tables(PlantStream& plant) {
  const PlantFile& file = plant.file;
  plant.lod_words = pack_lod_table(file);
  plant.valued.table = lod_table(file, plant.lod_words);
  plant.valued.leaf_count = file.plant.leaf_count;
  plant.valued.page_bytes = plant.gpu.page_bytes + 2 * COPPICE_PAGE_SPLITS * sizeof(PageNode);
  plant.card_looks = gpu::card_looks(file);
  plant.leaves = {.root = root_node(file.plant),
                  .looks = plant.card_looks,
                  .box = gpu::leaf_box(gpu::gpu_plant(file.plant)),
                  .leaf_count = file.plant.leaf_count};
  plant.base_bytes = sizeof(PlantStream) + plant.gpu.plant_bytes + file.chunks.bytes() + bytes_of(file.materials) + bytes_of(file.cards) +
                     bytes_of(file.error_leaf_counts) + bytes_of(file.error_sizes_px) + bytes_of(file.error_px) +
                     bytes_of(file.wood_error_px) + bytes_of(plant.lod_words) + bytes_of(plant.card_looks) + plant.chunks.bytes() +
                     plant.pages.bytes() + plant.page_nodes.bytes() + plant.wood.bytes() + plant.textures.bytes() +
                     plant.texture_uploads.bytes() + plant.leaf_meshes.bytes() + bytes_of(file.leaf_meshes) +
                     bytes_of(file.leaf_mesh_error_px);
}

}  // namespace

PlantStream::~PlantStream() {
  if (io_file >= 0) hooks.io.close(hooks.io.user, io_file);
}

Chunk& PlantStream::chunk(ChunkKind kind, std::uint32_t chunk_index) {
  const coppice_file_plant& counts = file.plant;
  const std::uint32_t first_texture = counts.page_count + counts.wood_lod_count;
  const std::array<std::uint32_t, 4> first = {0, counts.page_count, first_texture, first_texture + counts.texture_count};
  return chunks[first[static_cast<std::size_t>(kind)] + chunk_index];
}

Result<std::unique_ptr<PlantStream>> open_plant_file(const Hooks& hooks, const GpuSizes& gpu, const char* path, std::uint32_t index) {
  std::unique_ptr<PlantStream> plant(new (std::nothrow) PlantStream);
  if (!plant) return Error{Status::out_of_memory, "plant"};
  plant->hooks = hooks;
  plant->gpu = gpu;
  plant->index = index;
  plant->path = path;
  plant->io_file = hooks.io.open(hooks.io.user, path, &plant->file_bytes);
  if (plant->io_file < 0) return open_error(plant->io_file);
  if (plant->file_bytes < sizeof(coppice_file_header))
    return Error{Status::bad_file, "header: the file is shorter than one", 0, std::to_string(plant->file_bytes) + " bytes"};
  return plant;
}

Result<void> take_front(PlantStream& plant, std::span<const std::uint8_t> front) {
  COPPICE_TRY(file, read_front(front, plant.file_bytes, plant.hooks.allocator));
  plant.file = std::move(file);
  COPPICE_CHECK(allocate_arrays(plant));
  index_chunks(plant);
  for (std::uint32_t i = 0; i < plant.texture_uploads.size(); ++i)
    plant.texture_uploads[i].bytes = plant.file_chunk(plant.chunk(ChunkKind::texture, i)).bytes;
  mark_leaf_mesh_textures(plant);
  fill_tables(plant);
  plant.loadable_page_count = plant.file.plant.page_count;
  const PlantWants nothing = no_wants(plant);
  plant.wants = {nothing, nothing, nothing};
  return {};
}

// One that is damaged counts as stored: decoding refuses it.
void take_texture_header(PlantStream& plant, std::uint32_t texture, std::span<const std::uint8_t> header) {
  const auto layout = read_texture_header(header, plant.file_chunk(plant.chunk(ChunkKind::texture, texture)).bytes);
  if (!layout || layout->format == COPPICE_TEXTURE_RGBA8) return;
  plant.texture_uploads[texture].bytes = decoded_texture_bytes(*layout);
  plant.texture_uploads[texture].decoded = true;
}

void measure_box(PlantStream& plant) {
  const coppice_file_plant& file = plant.file.plant;
  std::copy_n(file.leaf_box_min, 3, plant.box.low.begin());
  std::copy_n(file.leaf_box_max, 3, plant.box.high.begin());
  if (file.wood_lod_count == 0) return;
  for (const WoodVertex& vertex : plant.wood[file.wood_lod_count - 1].vertices)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      plant.box.low[axis] = std::min(plant.box.low[axis], vertex.position[axis]);
      plant.box.high[axis] = std::max(plant.box.high[axis], vertex.position[axis]);
    }
}

void measure_leaf_meshes(PlantStream& plant) {
  plant.valued.leaf_mesh_bytes = 0;
  if (plant.file.plant.leaf_mesh_count == 0) return;
  for (const Chunk& chunk : plant.chunks.span())
    if (in_leaf_mesh_set(plant, chunk)) plant.valued.leaf_mesh_bytes += chunk_bytes(plant, chunk).gpu;
}

ChunkBytes chunk_bytes(const PlantStream& plant, const Chunk& chunk) {
  ChunkBytes bytes;
  bytes.work = plant.file_chunk(chunk).bytes;
  if (chunk.id.kind == ChunkKind::page) {
    const std::uint64_t splits = page_split_count(plant.file.plant.leaf_count, chunk.id.index);
    bytes.gpu = plant.gpu.page_bytes;
    bytes.kept = 2 * splits * sizeof(PageNode);
    bytes.upload = gpu::kPageBytes;
    if (chunk.id.index == 0) bytes.upload += gpu::ready_cut_bytes(plant.file.plant.leaf_count);
    bytes.work += sizeof(PageScratch) + sizeof(gpu::ClusterScratch);
  } else if (chunk.id.kind == ChunkKind::wood) {
    const std::uint64_t vertices = plant.file.plant.wood_vertex_counts[chunk.id.index];
    const std::uint64_t indices = 3 * std::uint64_t{plant.file.plant.wood_triangle_counts[chunk.id.index]};
    bytes.gpu = vertices * plant.gpu.wood_vertex_bytes + indices * plant.gpu.wood_index_bytes;
    bytes.upload = vertices * sizeof(WoodVertex) + indices * sizeof(std::uint32_t);
  } else if (chunk.id.kind == ChunkKind::leaf_mesh) {
    const auto [vertices, triangles] = plant.file.leaf_meshes[chunk.id.index];
    const std::uint64_t indices = 3 * std::uint64_t{triangles};
    bytes.gpu = vertices * plant.gpu.leaf_mesh_vertex_bytes + indices * plant.gpu.wood_index_bytes;
    bytes.upload = vertices * sizeof(WoodVertex) + indices * sizeof(std::uint32_t);
  } else {
    const TextureUpload& upload = plant.texture_uploads[chunk.id.index];
    bytes.gpu = bytes.upload = upload.bytes;
    if (!upload.decoded) bytes.work = 0;  // the file's bytes are what is uploaded
  }
  if (bytes.gpu > plant.gpu.most_staged_bytes) bytes.upload += bytes.gpu;
  return bytes;
}

bool in_leaf_mesh_set(const PlantStream& plant, const Chunk& chunk) {
  return chunk.id.kind == ChunkKind::leaf_mesh ||
         (chunk.id.kind == ChunkKind::texture && plant.texture_uploads[chunk.id.index].leaf_mesh_only);
}

std::uint64_t missing_leaf_mesh_bytes(const PlantStream& plant) {
  std::uint64_t bytes = 0;
  for (const Chunk& chunk : plant.chunks.span().subspan(plant.file.plant.page_count))
    if (chunk.residency == Residency::absent && in_leaf_mesh_set(plant, chunk)) bytes += chunk_bytes(plant, chunk).total();
  return bytes;
}

bool leaf_meshes_resident(const PlantStream& plant) {
  if (plant.file.plant.leaf_mesh_count == 0) return false;
  return std::ranges::all_of(plant.chunks.span().subspan(plant.file.plant.page_count),
                             [&](const Chunk& chunk) { return chunk.residency == Residency::resident || !in_leaf_mesh_set(plant, chunk); });
}

float chunk_value(const PlantStream& plant, const Chunk& chunk, const LodView& view) {
  if (plant.closing) return 0.0f;
  if (chunk.pinned) return std::numeric_limits<float>::infinity();
  const PlantWants& wants = plant.wants.unlimited;
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  switch (chunk.id.kind) {
    case ChunkKind::page:
      return page_value(plant.valued, wants, plant.demand, view, chunk.id.index);
    case ChunkKind::wood:
      return wood_value(plant.valued, wants, plant.demand, view, chunk.id.index, bytes.gpu);
    case ChunkKind::texture:
      if (in_leaf_mesh_set(plant, chunk)) return leaf_mesh_value(plant.valued, wants, plant.demand, view);
      return texture_value(wants, plant.demand, bytes.gpu);
    case ChunkKind::leaf_mesh:
      return leaf_mesh_value(plant.valued, wants, plant.demand, view);
  }
  return 0.0f;
}

void update_demand(PlantStream& plant, const PlantDemand& demand) {
  plant.demand = demand;
  RecentSize& recent = plant.recent_size;
  if (++recent.frames_in_window > kWantWindowFrames) {
    recent.last_window_px = std::exchange(recent.current_window_px, 0.0f);
    recent.frames_in_window = 1;
  }
  recent.current_window_px = std::max(recent.current_window_px, demand.max_size_px);
}

PlantWants no_wants(const PlantStream& plant) {
  return {.finest_wood = plant.file.plant.wood_lod_count};
}

PlantWants wants_at(const PlantStream& plant, float max_size_px, const LodView& view) {
  if (plant.closing) return no_wants(plant);
  PlantDemand demand = plant.demand;
  demand.max_size_px = max_size_px;
  ValuedPlant valued = plant.valued;
  if (!plant.leaf_meshes_affordable) valued.leaf_mesh_bytes = 0;
  PlantWants wants = plant_wants(valued, demand, view);
  wants.page_count = std::min(wants.page_count, plant.loadable_page_count);
  return wants;
}

namespace {

bool wanted_by(const PlantStream& plant, const PlantWants& wants, const Chunk& chunk) {
  switch (chunk.id.kind) {
    case ChunkKind::page:
      return chunk.id.index < wants.page_count;
    case ChunkKind::wood:
      return chunk.id.index >= wants.finest_wood;
    case ChunkKind::texture:
      return in_leaf_mesh_set(plant, chunk) ? wants.leaf_meshes : wants.textures && chunk.affordable;
    case ChunkKind::leaf_mesh:
      return wants.leaf_meshes;
  }
  return false;
}

}  // namespace

std::uint64_t list_bytes(const PlantStream& plant, const Chunk& chunk) {
  if (chunk.id.kind != ChunkKind::wood) return 0;
  return plant.file.plant.wood_triangle_counts[chunk.id.index] * plant.gpu.wood_list_triangle_bytes;
}

PlannedBytes planned_bytes(const PlantStream& plant, const PlantWants& wants) {
  PlannedBytes planned;
  const std::uint32_t page_count = plant.file.plant.page_count;
  if (wants.page_count > 1) planned.settled += (wants.page_count - 1) * plant.valued.page_bytes;
  if (plant.decoded_page_count < wants.page_count) {
    const ChunkBytes bytes = chunk_bytes(plant, plant.chunk(ChunkKind::page, plant.decoded_page_count));
    planned.passing = bytes.upload + bytes.work;
  }
  std::uint64_t set_passing = 0;
  for (const Chunk& chunk : plant.chunks.span().subspan(page_count)) {
    if (chunk.pinned || chunk.residency == Residency::failed || !wanted_by(plant, wants, chunk)) continue;
    const ChunkBytes bytes = chunk_bytes(plant, chunk);
    planned.settled += bytes.gpu + bytes.kept + list_bytes(plant, chunk);
    if (chunk.residency == Residency::resident) continue;
    const std::uint64_t passing = bytes.upload + bytes.work;
    if (in_leaf_mesh_set(plant, chunk))
      set_passing += passing;  // they are asked for together
    else
      planned.passing = std::max(planned.passing, passing);
  }
  planned.passing = std::max(planned.passing, set_passing);
  return planned;
}

// What is damaged will never be complete: the other leaf meshes are not worth their memory.
void give_up(PlantStream& plant, const Chunk& chunk) {
  if (chunk.id.kind == ChunkKind::page) plant.loadable_page_count = std::min(plant.loadable_page_count, chunk.id.index);
  if (in_leaf_mesh_set(plant, chunk)) plant.valued.leaf_mesh_bytes = 0;
}

// What is pinned is absent only where the device had no memory for it.
bool wanted_now(const PlantStream& plant, const Chunk& chunk) {
  return (chunk.pinned && !plant.closing) || wanted_by(plant, plant.wants.now, chunk);
}

bool wanted_recently(const PlantStream& plant, const Chunk& chunk) {
  return chunk.pinned || wanted_by(plant, plant.wants.recent, chunk);
}

Result<void> prepare_page(PlantStream& plant, Transfer& transfer) {
  const std::uint32_t page = transfer.chunk->id.index;
  const std::size_t splits = page_split_count(plant.file.plant.leaf_count, page);
  const coppice_allocator& allocator = plant.hooks.allocator;
  PageData data;
  COPPICE_CHECK(allocate_into(data.nodes, allocator, 2 * splits));
  COPPICE_CHECK(allocate_into(data.clusters, allocator, gpu::kPageBytes));
  COPPICE_CHECK(allocate_into(transfer.scratch, allocator, 1));
  COPPICE_CHECK(allocate_into(transfer.cluster_scratch, allocator, 1));
  if (page == 0) COPPICE_CHECK(allocate_into(plant.ready_cuts.bytes, allocator, gpu::ready_cut_bytes(plant.file.plant.leaf_count)));
  plant.pages[page] = std::move(data);
  plant.page_nodes[page] = plant.pages[page].nodes.data();
  transfer.page = {{&plant.leaves.root, std::span<PageNode* const>(plant.page_nodes.data(), page + 1)}, {}};
  return {};
}

namespace {

Result<void> decode_page_chunk(Transfer& transfer) {
  PlantStream& plant = *transfer.plant;
  const coppice_file_plant& file = plant.file.plant;
  const std::uint32_t page = transfer.chunk->id.index;
  const PageInfo info{page, file.leaf_count, file.card_count, quantised_max(file)};
  COPPICE_CHECK(decode_page(transfer.bytes.span(), info, transfer.page, transfer.scratch[0]));
  PageData& data = plant.pages[page];
  const std::span<const PageNode> nodes = data.nodes.span();
  gpu::ClusterScratch& scratch = transfer.cluster_scratch[0];
  // Once page 0 is there it stays: what is measured from it need not change as finer leaves come and go.
  if (page == 0) {
    plant.light = std::make_shared<gpu::CrownLight>(gpu::measure_crown({plant.leaves.root, nodes, plant.card_looks, plant.leaves.box}));
    plant.leaves.light = plant.light.get();
    gpu::build_ready_cuts(plant.leaves, nodes, scratch, plant.ready_cuts);
  }
  gpu::build_page(plant.leaves, page, nodes, scratch, data.clusters.span());
  return {};
}

Result<void> decode_texture_chunk(Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  const TextureUpload& upload = plant.texture_uploads[transfer.chunk->id.index];
  auto layout = read_texture(transfer.bytes.span());
  if (!layout) {
    Error error = layout.error();
    error.offset += plant.file_chunk(*transfer.chunk).offset;
    return error;
  }
  if (!upload.decoded) return {};
  if (decoded_texture_bytes(*layout) != upload.bytes)
    return Error{Status::bad_file, "texture header: not what it was when the plant was opened", plant.file_chunk(*transfer.chunk).offset};
  COPPICE_CHECK(allocate_into(transfer.texels, plant.hooks.allocator, static_cast<std::size_t>(upload.bytes)));
  decode_texture(*layout, transfer.bytes.span(), transfer.texels.span());
  return {};
}

}  // namespace

namespace {

WoodShape mesh_shape(const PlantFile& file, ChunkId id) {
  if (id.kind == ChunkKind::leaf_mesh)
    return {file.leaf_meshes[id.index].vertex_count, file.leaf_meshes[id.index].triangle_count, file.materials, true};
  return {file.plant.wood_vertex_counts[id.index], file.plant.wood_triangle_counts[id.index], file.materials, false};
}

}  // namespace

Result<void> decode_chunk(Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  const Chunk& chunk = *transfer.chunk;
  const std::span<const std::uint8_t> bytes = transfer.bytes.span();
  COPPICE_CHECK(check_chunk(plant.file_chunk(chunk), bytes));
  if (chunk.id.kind == ChunkKind::page) return decode_page_chunk(transfer);
  if (chunk.id.kind == ChunkKind::texture) return decode_texture_chunk(transfer);
  COPPICE_TRY(wood, decode_wood(bytes, mesh_shape(plant.file, chunk.id)));
  transfer.wood = std::move(wood);
  return {};
}

void accept_decoded(PlantStream& plant, Transfer& transfer) {
  if (transfer.chunk->id.kind == ChunkKind::page) return;  // decoded into the plant's pages
  const std::uint32_t index = transfer.chunk->id.index;
  if (transfer.chunk->id.kind == ChunkKind::wood)
    plant.wood[index] = std::move(transfer.wood);
  else if (transfer.chunk->id.kind == ChunkKind::leaf_mesh)
    plant.leaf_meshes[index] = std::move(transfer.wood);
  else
    plant.textures[index] = std::move(plant.texture_uploads[index].decoded ? transfer.texels : transfer.bytes);
}

void free_clusters(PlantStream& plant, std::uint32_t page) {
  plant.pages[page].clusters.reset();
  if (page == 0) plant.ready_cuts.bytes.reset();
}

void free_page(PlantStream& plant, std::uint32_t page) {
  plant.pages[page] = PageData{};
  plant.page_nodes[page] = nullptr;
}

void free_decoded(PlantStream& plant, ChunkId id) {
  COPPICE_ASSERT(id.kind != ChunkKind::page);
  if (id.kind == ChunkKind::wood)
    plant.wood[id.index] = WoodMesh{};
  else if (id.kind == ChunkKind::leaf_mesh)
    plant.leaf_meshes[id.index] = WoodMesh{};
  else
    plant.textures[id.index].reset();
}

}  // namespace coppice
