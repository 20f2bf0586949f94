#include "plant_stream.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <new>

#include "block_texture.h"
#include "card_looks.h"
#include "check.h"
#include "convert.h"

namespace coppice {

namespace {

constexpr std::uint32_t kDemandWindowFrames = 8;

DemandedDetail no_demand(const PlantStream& plant) {
  return {.finest_wood = plant.file.plant.wood_lod_count};
}

/// The kinds of chunks that the streamer loads by itself, by ChunkKind.
constexpr std::array<std::uint32_t, kChunkKindCount> kStreamedKinds = {COPPICE_CHUNK_PAGE, COPPICE_CHUNK_WOOD, COPPICE_CHUNK_TEXTURE,
                                                                       COPPICE_CHUNK_LEAF_MESH};

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

/// Finds every chunk in the file's table. The reader has checked that each is there once.
void index_chunks(PlantStream& plant) {
  const coppice_file_plant& counts = plant.file.plant;
  std::size_t found = 0;
  for (std::uint32_t i = 0; i < plant.file.chunks.size(); ++i) {
    const coppice_file_chunk& entry = plant.file.chunks[i];
    const auto position = std::ranges::find(kStreamedKinds, entry.kind);
    if (position == kStreamedKinds.end()) continue;
    const auto kind = static_cast<ChunkKind>(position - kStreamedKinds.begin());
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

Result<void> fill_tables(PlantStream& plant) {
  const PlantFile& file = plant.file;
  COPPICE_CHECK(move_into(plant.lod_words, pack_lod_table(file, plant.hooks.allocator)));
  plant.valued.table = lod_table(file, plant.lod_words);
  plant.valued.leaf_count = file.plant.leaf_count;
  plant.valued.page_bytes = plant.gpu.form->page_bytes(COPPICE_PAGE_SPLITS) + 2 * COPPICE_PAGE_SPLITS * sizeof(PageNode);
  COPPICE_CHECK(move_into(plant.looks, gpu::plant_looks(file, plant.hooks.allocator)));
  plant.file.small_textures.reset();
  plant.leaves = {.root = root_node(file.plant),
                  .looks = plant.looks.cards(),
                  .box = gpu::leaf_box(gpu::gpu_plant(file.plant)),
                  .leaf_count = file.plant.leaf_count};
  if (const std::uint32_t lods = file.plant.wood_lod_count; lods > 0)
    COPPICE_CHECK(allocate_into(plant.coarse_wood, plant.hooks.allocator, file.plant.wood_triangle_counts[lods - 1]));
  plant.base_bytes = sizeof(PlantStream) + plant.coarse_wood.bytes() + plant.gpu.plant_bytes + plant.path.bytes() + file.bytes() +
                     plant.lod_words.bytes() + plant.looks.bytes() + plant.chunks.bytes() + plant.pages.bytes() + plant.page_nodes.bytes() +
                     plant.wood.bytes() + plant.textures.bytes() + plant.texture_uploads.bytes() + plant.leaf_meshes.bytes();
  return {};
}

/// Without block textures they are decoded.
Result<void> measure_textures(PlantStream& plant) {
  for (std::uint32_t i = 0; i < plant.texture_uploads.size(); ++i) {
    COPPICE_TRY(layout, texture_layout(plant.file.textures[i]));
    const bool decoded = !plant.gpu.block_textures && layout.format != COPPICE_TEXTURE_RGBA8;
    plant.texture_uploads[i] = {.bytes = decoded ? decoded_texture_bytes(layout) : layout.bytes, .decoded = decoded};
  }
  return {};
}

void measure_leaf_meshes(PlantStream& plant) {
  plant.valued.leaf_mesh_bytes = 0;
  if (plant.file.plant.leaf_mesh_count == 0) return;
  std::uint64_t passing = 0;
  for (const Chunk& chunk : plant.chunks.span()) {
    if (!in_leaf_mesh_set(plant, chunk)) continue;
    const ChunkBytes bytes = chunk_bytes(plant, chunk);
    plant.valued.leaf_mesh_bytes += bytes.gpu;
    passing = std::max(passing, bytes.total() - bytes.gpu);
  }
  plant.leaf_mesh_load_bytes = plant.valued.leaf_mesh_bytes + passing;
}

WoodShape mesh_shape(const PlantFile& file, ChunkId id) {
  if (id.kind == ChunkKind::leaf_mesh)
    return {file.leaf_meshes[id.index].vertex_count, file.leaf_meshes[id.index].triangle_count, file.materials, true};
  return {file.plant.wood_vertex_counts[id.index], file.plant.wood_triangle_counts[id.index], file.materials, false};
}

gpu::MeshKind mesh_kind(ChunkId id) {
  return id.kind == ChunkKind::wood ? gpu::MeshKind::wood : gpu::MeshKind::leaves;
}

ChunkBytes mesh_bytes(const PlantStream& plant, ChunkId id) {
  const WoodShape shape = mesh_shape(plant.file, id);
  ChunkBytes bytes;
  bytes.gpu = plant.mesh(id).gpu_bytes;
  if (bytes.gpu == 0) bytes.gpu = plant.gpu.form->mesh_bytes(mesh_kind(id), shape);
  bytes.upload = bytes.gpu;
  bytes.work = shape.vertex_count * sizeof(WoodVertex) + 3 * std::uint64_t{shape.triangle_count} * sizeof(std::uint32_t) +
               plant.gpu.form->mesh_scratch_bytes(shape.triangle_count);
  return bytes;
}

std::span<const std::uint8_t>& memory_of(void* user) {
  return *static_cast<std::span<const std::uint8_t>*>(user);
}

/// A hook that answers inline from `bytes`, which outlive it.
coppice_io memory_io(std::span<const std::uint8_t>& bytes) {
  const auto open = [](void* user, const char*, std::uint64_t* file_bytes) -> std::int64_t {
    *file_bytes = memory_of(user).size();
    return 0;
  };
  const auto read = [](void* user, std::int64_t, std::uint64_t offset, void* destination, std::size_t count,
                       void (*done)(void* argument, std::int64_t bytes_read), void* argument) {
    const std::span<const std::uint8_t> there = memory_of(user).subspan(std::min<std::uint64_t>(offset, memory_of(user).size()));
    const std::span<const std::uint8_t> taken = there.first(std::min(count, there.size()));
    std::ranges::copy(taken, static_cast<std::uint8_t*>(destination));
    done(argument, static_cast<std::int64_t>(taken.size()));
  };
  return {sizeof(coppice_io), &bytes, open, [](void*, std::int64_t) {}, read, nullptr};
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

MeshData& PlantStream::mesh(ChunkId id) {
  return id.kind == ChunkKind::wood ? wood[id.index] : leaf_meshes[id.index];
}

Result<std::unique_ptr<PlantStream>> open_plant_file(const Hooks& hooks, const GpuSizes& gpu, const PlantSource& source,
                                                     std::uint32_t index) {
  std::unique_ptr<PlantStream> plant(new (std::nothrow) PlantStream);
  if (!plant) return Error{Status::out_of_memory, "plant"};
  plant->hooks = hooks;
  plant->gpu = gpu;
  plant->index = index;
  COPPICE_CHECK(move_into(plant->path, copied_text(source.name, hooks.allocator)));
  plant->memory = source.bytes;
  if (!source.bytes.empty()) plant->hooks.io = memory_io(plant->memory);
  const coppice_io& io = plant->hooks.io;
  plant->io_file = io.open(io.user, source.name, &plant->file_bytes);
  if (plant->io_file < 0) return open_error(plant->io_file);
  if (plant->file_bytes < sizeof(coppice_file_header))
    return Error{Status::bad_file, "header: the file is shorter than one", 0, std::to_string(plant->file_bytes) + " bytes"};
  return plant;
}

Result<void> take_front(PlantStream& plant, std::span<const std::uint8_t> front) {
  COPPICE_CHECK(move_into(plant.file, read_front(front, plant.file_bytes, plant.hooks.allocator)));
  COPPICE_CHECK(allocate_arrays(plant));
  index_chunks(plant);
  COPPICE_CHECK(measure_textures(plant));
  mark_leaf_mesh_textures(plant);
  COPPICE_CHECK(fill_tables(plant));
  measure_leaf_meshes(plant);
  plant.loadable_page_count = plant.file.plant.page_count;
  const DemandedDetail nothing = no_demand(plant);
  plant.demanded = {nothing, nothing, nothing};
  return {};
}

void take_coarse_wood(PlantStream& plant) {
  const coppice_file_plant& file = plant.file.plant;
  std::copy_n(file.leaf_box_min, 3, plant.box.low.begin());
  std::copy_n(file.leaf_box_max, 3, plant.box.high.begin());
  if (file.wood_lod_count == 0) return;
  const gpu::MeshBlock& coarsest = plant.wood[file.wood_lod_count - 1].block;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    plant.box.low[axis] = std::min(plant.box.low[axis], coarsest.low[axis]);
    plant.box.high[axis] = std::max(plant.box.high[axis], coarsest.high[axis]);
  }
  const vec3 low(plant.box.low), size = vec3(plant.box.high) - low;
  const std::uint8_t* bytes = coarsest.bytes.data();
  const MeshLayout at = plant.gpu.form->mesh_layout(coarsest);
  for (std::size_t i = 0; i < 3 * plant.coarse_wood.size(); ++i) {
    std::uint32_t vertex = 0;
    std::array<float, 3> position{};
    std::memcpy(&vertex, bytes + at.indices + i * sizeof vertex, sizeof vertex);
    std::memcpy(&position, bytes + at.vertices + vertex * at.vertex_bytes, sizeof position);
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (size[axis] > 0.0f)
        plant.coarse_wood[i / 3][i % 3][axis] =
            static_cast<std::uint16_t>(std::lround(std::clamp((position[axis] - low[axis]) / size[axis], 0.0f, 1.0f) * kBoxSteps));
  }
}

ChunkBytes chunk_bytes(const PlantStream& plant, const Chunk& chunk) {
  ChunkBytes bytes;
  if (chunk.id.kind == ChunkKind::page) {
    const std::uint64_t splits = page_split_count(plant.file.plant.leaf_count, chunk.id.index);
    bytes.kept = 2 * splits * sizeof(PageNode);
    bytes.gpu = plant.gpu.form->page_bytes(splits);
    bytes.upload = plant.gpu.form->page_upload_bytes(chunk.id.index, plant.file.plant.leaf_count);
    bytes.work = sizeof(PageScratch) + sizeof(gpu::ClusterScratch) + DecoderPool::kSetBytes;
  } else if (chunk.id.kind != ChunkKind::texture) {
    bytes = mesh_bytes(plant, chunk.id);
  } else {
    const TextureUpload& upload = plant.texture_uploads[chunk.id.index];
    bytes.gpu = bytes.upload = upload.bytes;
  }
  const bool stored = chunk.id.kind == ChunkKind::texture && !plant.texture_uploads[chunk.id.index].decoded;
  if (!stored) bytes.work += plant.file_chunk(chunk).bytes;  // stored ones are uploaded as they are
  return bytes;
}

std::uint64_t lump_bytes(const PlantStream& plant, const Chunk& chunk) {
  const ChunkBytes bytes = chunk_bytes(plant, chunk);
  return chunk.id.kind == ChunkKind::texture ? bytes.gpu : bytes.total();
}

bool in_leaf_mesh_set(const PlantStream& plant, const Chunk& chunk) {
  return chunk.id.kind == ChunkKind::leaf_mesh ||
         (chunk.id.kind == ChunkKind::texture && plant.texture_uploads[chunk.id.index].leaf_mesh_only);
}

bool leaf_meshes_resident(const PlantStream& plant) {
  if (plant.file.plant.leaf_mesh_count == 0) return false;
  return std::ranges::all_of(plant.other_chunks(),
                             [&](const Chunk& chunk) { return chunk.residency == Residency::resident || !in_leaf_mesh_set(plant, chunk); });
}

namespace {

float value_to(const PlantStream& plant, const Chunk& chunk, const PlantDemand& demand, const LodView& view) {
  const DemandedDetail& demanded = plant.demanded.unlimited;
  switch (chunk.id.kind) {
    case ChunkKind::page:
      return page_value(plant.valued, demanded, demand, view, chunk.id.index);
    case ChunkKind::wood:
      return wood_value(plant.valued, demanded, demand, view, chunk.id.index, chunk_bytes(plant, chunk).gpu);
    case ChunkKind::texture:
      if (in_leaf_mesh_set(plant, chunk)) return leaf_mesh_value(plant.valued, demanded, demand, view);
      return texture_value(demanded, demand, chunk_bytes(plant, chunk).gpu);
    case ChunkKind::leaf_mesh:
      return leaf_mesh_value(plant.valued, demanded, demand, view);
  }
  return 0.0f;
}

float summed_value(const PlantStream& plant, const Chunk& chunk, const GroupViews& views) {
  if (plant.closing) return 0.0f;
  if (chunk.pinned) return std::numeric_limits<float>::infinity();
  float value = 0.0f;
  for (std::size_t group = 0; group < kMaxViewGroups; ++group)
    if (views[group] && plant.demands[group].now.max_size_px > 0.0f)
      value += value_to(plant, chunk, plant.demands[group].now, *views[group]);
  return value;
}

}  // namespace

float chunk_value(const PlantStream& plant, Chunk& chunk, const CurrentFrame& frame) {
  if (std::exchange(chunk.value_frame, frame.number) != frame.number) chunk.value = summed_value(plant, chunk, frame.views);
  return chunk.value;
}

void update_demand(GroupDemand& of, const PlantDemand& demand) {
  of.now = demand;
  RecentSize& recent = of.recent;
  if (++recent.frames_in_window > kDemandWindowFrames) {
    recent.last_window_px = std::exchange(recent.current_window_px, 0.0f);
    recent.frames_in_window = 1;
  }
  recent.current_window_px = std::max(recent.current_window_px, demand.max_size_px);
}

float max_size_px(const GroupDemand& demand, DemandSize size) {
  return size == DemandSize::now ? demand.now.max_size_px : demand.recent.px();
}

namespace {

/// True if a lump is small enough. One that is there is kept a little longer, so that small changes of the view do not swap it back and
/// forth.
bool within(const Chunk& chunk, std::uint64_t bytes, std::uint64_t limit_bytes) {
  return (chunk.residency == Residency::absent ? bytes : bytes / 4 * 3) <= limit_bytes;
}

bool leaf_meshes_within(const PlantStream& plant, std::uint64_t limit_bytes) {
  return plant.file.plant.leaf_mesh_count > 0 && within(plant.chunk(ChunkKind::leaf_mesh, 0), plant.leaf_mesh_load_bytes, limit_bytes);
}

/// The finest of a plant's wood LoDs, from `finest` on, that is small enough, as are all coarser ones.
std::uint32_t finest_wood_within(const PlantStream& plant, std::uint32_t finest, std::uint64_t limit_bytes) {
  const std::uint32_t count = plant.file.plant.wood_lod_count;
  if (finest >= count) return count;
  std::uint32_t lod = count - 1;  // which is pinned
  for (; lod > finest; --lod) {
    const Chunk& finer = plant.chunk(ChunkKind::wood, lod - 1);
    if (!within(finer, lump_bytes(plant, finer), limit_bytes)) break;
  }
  return lod;
}

/// Calls ask(demand, view) for each view group that sees the plant.
template <class Ask>
void for_each_group(const PlantStream& plant, DemandSize size, const GroupViews& views, const Ask& ask) {
  for (std::size_t group = 0; group < kMaxViewGroups; ++group) {
    const float size_px = max_size_px(plant.demands[group], size);
    if (!views[group] || size_px == 0.0f) continue;
    PlantDemand demand = plant.demands[group].now;
    demand.max_size_px = size_px;
    ask(demand, *views[group]);
  }
}

}  // namespace

DemandedDetail demanded_at(const PlantStream& plant, DemandSize size, const DemandViews& views) {
  DemandedDetail pages = no_demand(plant), lumps = pages;
  if (plant.closing) return pages;
  ValuedPlant valued = plant.valued;
  const bool may_have_meshes = leaf_meshes_within(plant, views.limits.other_bytes);
  for_each_group(plant, size, views.lumps, [&](const PlantDemand& demand, const LodView& view) {
    lumps.leaf_meshes = lumps.leaf_meshes || (may_have_meshes && demands_leaf_meshes(valued, demand, view));
    lumps.finest_wood = std::min(lumps.finest_wood, demanded_wood(valued, demand, view));
    if (views.every_texture || needs_textures(demand, view)) lumps.max_texture_bytes = views.limits.texture_bytes;
  });
  if (!lumps.leaf_meshes) valued.leaf_mesh_bytes = 0;
  for_each_group(plant, size, views.pages, [&](const PlantDemand& demand, const LodView& view) {
    pages = merged(pages, demanded_detail(valued, demand, view, lumps.leaf_meshes));
  });
  lumps.page_count = std::min(pages.page_count, plant.loadable_page_count);
  lumps.finest_wood = finest_wood_within(plant, lumps.finest_wood, views.limits.other_bytes);
  return lumps;
}

namespace {

bool demanded_by(const PlantStream& plant, const DemandedDetail& demanded, const Chunk& chunk) {
  switch (chunk.id.kind) {
    case ChunkKind::page:
      return chunk.id.index < demanded.page_count;
    case ChunkKind::wood:
      return chunk.id.index >= demanded.finest_wood;
    case ChunkKind::texture:
      if (in_leaf_mesh_set(plant, chunk)) return demanded.leaf_meshes;
      return within(chunk, lump_bytes(plant, chunk), demanded.max_texture_bytes);
    case ChunkKind::leaf_mesh:
      return demanded.leaf_meshes;
  }
  return false;
}

}  // namespace

PlannedBytes planned_bytes(const PlantStream& plant, const DemandedDetail& demanded) {
  PlannedBytes planned;
  if (demanded.page_count > 1) planned.settled += (demanded.page_count - 1) * plant.valued.page_bytes;
  if (plant.decoded_page_count < demanded.page_count) {
    const ChunkBytes bytes = chunk_bytes(plant, plant.chunk(ChunkKind::page, plant.decoded_page_count));
    planned.passing = bytes.upload + bytes.work;
  }
  for (const Chunk& chunk : plant.other_chunks()) {
    if (chunk.pinned || chunk.residency == Residency::failed || !demanded_by(plant, demanded, chunk)) continue;
    const ChunkBytes bytes = chunk_bytes(plant, chunk);
    planned.settled += bytes.gpu + bytes.kept;
    if (chunk.residency != Residency::resident) planned.passing = std::max(planned.passing, bytes.upload + bytes.work);
  }
  return planned;
}

// A damaged set never becomes complete: the other leaf meshes are not worth their memory.
void give_up(PlantStream& plant, const Chunk& chunk) {
  if (chunk.id.kind == ChunkKind::page) plant.loadable_page_count = std::min(plant.loadable_page_count, chunk.id.index);
  if (in_leaf_mesh_set(plant, chunk)) plant.valued.leaf_mesh_bytes = 0;
}

void forget_failures(PlantStream& plant, bool unreadable_only) {
  for (Chunk& chunk : plant.chunks.span()) {
    if (chunk.residency != Residency::failed || (unreadable_only && !chunk.unreadable)) continue;
    COPPICE_ASSERT(advance(chunk, Residency::absent));
    if (!unreadable_only) chunk.unreadable = false;
  }
  measure_leaf_meshes(plant);
  plant.loadable_page_count = plant.file.plant.page_count;
  for (const Chunk& chunk : plant.chunks.span())
    if (chunk.residency == Residency::failed) give_up(plant, chunk);
}

// A pinned chunk is only absent if the device had no memory for it.
bool is_demanded(const PlantStream& plant, const DemandedDetail& demanded, const Chunk& chunk) {
  return (chunk.pinned && !plant.closing) || demanded_by(plant, demanded, chunk);
}

bool demanded_recently(const PlantStream& plant, const Chunk& chunk) {
  return chunk.pinned || demanded_by(plant, plant.demanded.recent, chunk);
}

Result<void> prepare_page(PlantStream& plant, Transfer& transfer) {
  const std::uint32_t page = transfer.chunk->id.index;
  const std::size_t splits = page_split_count(plant.file.plant.leaf_count, page);
  const coppice_allocator& allocator = plant.hooks.allocator;
  PageData data;
  COPPICE_CHECK(allocate_into(data.nodes, allocator, 2 * splits));
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
  COPPICE_CHECK(allocate_into(transfer.scratch, plant.hooks.allocator, 1));
  COPPICE_CHECK(plant.gpu.form->prepare_page(plant, transfer, plant.pages[page]));
  COPPICE_CHECK(decode_page(transfer.bytes.span(), info, transfer.page, transfer.scratch[0], *plant.decoders));
  plant.gpu.form->build_page(plant, transfer);
  return {};
}

Result<void> decode_texture_chunk(Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  const std::uint32_t index = transfer.chunk->id.index;
  const TextureUpload& upload = plant.texture_uploads[index];
  COPPICE_CHECK(check_texture(plant.file, index, transfer.bytes.span()));
  if (!upload.decoded) return {};
  COPPICE_TRY(layout, texture_layout(plant.file.textures[index]));
  COPPICE_CHECK(
      move_into(transfer.texels, HookBuffer::allocate_for_overwrite(plant.hooks.allocator, static_cast<std::size_t>(upload.bytes))));
  decode_texture(layout, transfer.bytes.span(), transfer.texels.span());
  return {};
}

}  // namespace

Result<void> decode_chunk(Transfer& transfer) {
  const PlantStream& plant = *transfer.plant;
  const Chunk& chunk = *transfer.chunk;
  const std::span<const std::uint8_t> bytes = transfer.bytes.span();
  COPPICE_CHECK(check_chunk(plant.file_chunk(chunk), bytes));
  if (chunk.id.kind == ChunkKind::page) return decode_page_chunk(transfer);
  if (chunk.id.kind == ChunkKind::texture) return decode_texture_chunk(transfer);
  COPPICE_TRY(mesh, decode_wood(bytes, mesh_shape(plant.file, chunk.id), plant.hooks.allocator));
  return move_into(transfer.mesh, plant.gpu.form->build_mesh(plant, mesh_kind(chunk.id), mesh));
}

bool keeps_bytes(const Transfer& transfer) {
  const ChunkId id = transfer.chunk->id;
  return id.kind == ChunkKind::texture && !transfer.plant->texture_uploads[id.index].decoded;
}

void accept_decoded(PlantStream& plant, Transfer& transfer) {
  const ChunkId id = transfer.chunk->id;
  if (id.kind == ChunkKind::page) return;  // decoded into the plant's pages
  if (id.kind == ChunkKind::texture) {
    plant.textures[id.index] = std::move(plant.texture_uploads[id.index].decoded ? transfer.texels : transfer.bytes);
    return;
  }
  MeshData& mesh = plant.mesh(id);
  mesh.block = std::move(transfer.mesh);
  mesh.gpu_bytes = mesh.block.bytes.size();
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
  if (id.kind == ChunkKind::texture)
    plant.textures[id.index].reset();
  else
    plant.mesh(id).block = {};
}

}  // namespace coppice
