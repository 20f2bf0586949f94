#pragma once

// What lives on the GPU of each plant: its tables, pages, meshes and textures.

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "coppice/vulkan.h"
#include "coppice_shared.h"
#include "crown_light.h"
#include "mesh_clusters.h"
#include "page_clusters.h"
#include "plant_tables.h"
#include "reader.h"
#include "texture_sets.h"
#include "uploads.h"

namespace coppice::gpu {

// What is uploaded is moved to its addresses where it lies.

/// A page's leaves; see page_clusters.h.
struct PageUpload {
  std::uint32_t plant = 0;
  std::uint32_t page = 0;
  std::span<std::uint8_t> clusters;  ///< of build_page
  ReadyCuts* ready_cuts = nullptr;   ///< of page 0
};

/// A wood LoD or a chunk of leaf meshes; see mesh_clusters.h.
struct MeshUpload {
  std::uint32_t plant = 0;
  std::uint32_t mesh = 0;  ///< wood LoD, or kMaxWoodLods + chunk of leaf meshes
  MeshBlock* block = nullptr;
};

/// Of a material; kNoTexture where it has none.
struct SurfaceTextures {
  std::uint32_t color = kNoTexture, normal_map = kNoTexture;

  bool operator==(const SurfaceTextures&) const = default;
};

struct StoredMesh {
  Buffer buffer;  ///< a MeshBlock's bytes
  uvec2 vertices{};
  std::uint32_t index_count = 0, cluster_count = 0;
  BoundedList<SurfaceTextures> textures;  ///< used by its vertices; distinct
};

struct StoredTexture {
  Texture texture;
  DescriptorSet set;
  bool visible = false;
};

struct StoredPlant {
  Plant record{};  ///< without what changes from frame to frame
  Buffer tables;
  PlantTables layout;                        ///< of `tables`
  bool has_cuts = false;                     ///< its leaves can be drawn
  bool has_gaps = false;                     ///< leaves that ever were there have
  HookArray<Buffer> pages;                   ///< [page] null where it is not there
  BoundedList<std::uint32_t> leaf_textures;  ///< used by its cards, kNoTexture included; distinct
  HookArray<SurfaceTextures> material_textures;
  std::array<StoredMesh, kMeshCommands> meshes;  ///< wood LoDs, then leaf meshes
  std::uint32_t leaf_mesh_count = 0;
  HookArray<StoredTexture> textures;
  HookBuffer pending_tables;               ///< contents of `tables`, until the next upload
  HookArray<std::uint32_t> pending_words;  ///< the packed table, until the next upload
};

/// Thread: externally serialised; const functions may overlap.
class PlantStore {
 public:
  /// All outlive this object.
  PlantStore(Device& device, Garbage& garbage, Uploads& uploads, const TextureSets& texture_sets, const coppice_allocator& allocator)
      : device_(device), garbage_(garbage), uploads_(uploads), texture_sets_(texture_sets), allocator_(allocator) {}
  /// The GPU must be done with everything.
  ~PlantStore();
  PlantStore(const PlantStore&) = delete;
  PlantStore& operator=(const PlantStore&) = delete;

  /// The placeholder. errors  out_of_memory
  Result<void> create();
  /// Room for so many. errors  out_of_memory; nothing has changed
  Result<void> reserve(std::uint32_t count);
  /// Up to the last that was ever added.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  /// Null where there is none.
  [[nodiscard]] const StoredPlant* plant(std::uint32_t index) const { return plants_[index].get(); }
  /// White, 1 x 1.
  [[nodiscard]] const StoredTexture& placeholder() const { return placeholder_; }
  /// That texture of a plant, or, where it is not there, the placeholder.
  [[nodiscard]] const StoredTexture& shown_texture(std::uint32_t plant, std::uint32_t texture) const;

  /// index: there is room for it, and it is not in use. lod_words: pack_lod_table of the file. errors  out_of_memory
  Result<void> add(std::uint32_t index, const PlantFile& file, const PlantAppearance& appearance, std::span<const std::uint32_t> lod_words);
  /// The GPU must have finished the last frame that drew the plant; its tables may still be on their way. Its chunks have been dropped.
  void remove(std::uint32_t index);

  /// errors  out_of_memory: the chunk is not there
  Result<void> upload_page(const PageUpload& upload);
  Result<void> upload_mesh(const MeshUpload& upload);
  /// bytes: a TEXTURE chunk. errors  bad_file: the field and its offset; unsupported: blocks, and the device does not take them;
  /// out_of_memory
  Result<void> upload_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> bytes);
  /// Uploads what plants that were added begin with, and the placeholder. words: of the packed tables, kTableStride a plant. errors
  /// out_of_memory: the rest waits
  Result<void> upload_tables(const Buffer& words);

  /// The GPU must have finished the last frame that drew the chunk.
  void drop_page(std::uint32_t plant, std::uint32_t page);
  /// mesh: MeshUpload's
  void drop_mesh(std::uint32_t plant, std::uint32_t mesh);
  void drop_texture(std::uint32_t plant, std::uint32_t texture);
  /// Stops drawing with the texture; drop_texture follows when the GPU is done.
  void hide_texture(std::uint32_t plant, std::uint32_t texture) { plants_[plant]->textures[texture].visible = false; }

 private:
  Result<void> fill_tables(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance);
  Result<void> add_single_leaf(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance);
  Result<void> patch_tables(StoredPlant& plant, std::uint64_t offset, std::span<const std::uint8_t> bytes);
  Result<void> patch_cuts(StoredPlant& plant, ReadyCuts& cuts);
  /// Creates a buffer and has `stage` stage its contents; undone where that fails.
  template <class Stage>
  Result<void> upload(Buffer& place, const BufferDesc& desc, Stage stage);
  void destroy(StoredPlant& plant);
  void destroy(StoredTexture& texture);

  Device& device_;
  Garbage& garbage_;
  Uploads& uploads_;
  const TextureSets& texture_sets_;
  coppice_allocator allocator_;
  HookArray<std::unique_ptr<StoredPlant>> plants_;
  std::uint32_t count_ = 0;
  StoredTexture placeholder_;  ///< visible once its texel is on its way
};

}  // namespace coppice::gpu
