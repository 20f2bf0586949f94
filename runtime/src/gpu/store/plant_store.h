#pragma once

// The data of each plant on the GPU: its tables, pages, meshes and textures.

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

// Addresses in uploaded data are adjusted in place.

/// A page's leaves; see page_clusters.h.
struct PageUpload {
  std::uint32_t plant = 0;
  std::uint32_t page = 0;
  std::span<std::uint8_t> clusters;  ///< from build_page
  ReadyCuts* ready_cuts = nullptr;   ///< only for page 0
};

/// A wood LoD or a chunk of leaf meshes; see mesh_clusters.h.
struct MeshUpload {
  std::uint32_t plant = 0;
  std::uint32_t mesh = 0;  ///< a wood LoD, or kMaxWoodLods + a chunk of leaf meshes
  MeshBlock* block = nullptr;
};

/// The textures of a material; kNoTexture if it has none.
struct SurfaceTextures {
  std::uint32_t color = kNoTexture, normal_map = kNoTexture;

  bool operator==(const SurfaceTextures&) const = default;
};

struct StoredMesh {
  Buffer buffer;  ///< a MeshBlock's bytes
  uvec2 vertices{};
  std::uint32_t index_count = 0, cluster_count = 0;
  BoundedList<SurfaceTextures> textures;  ///< those that its vertices use; distinct
};

struct StoredTexture {
  Texture texture;
  DescriptorSet set;
  bool visible = false;
};

struct StoredPlant {
  Plant record{};  ///< without the fields that change from frame to frame
  Buffer tables;
  PlantTables layout;                        ///< layout of `tables`
  bool has_cuts = false;                     ///< its leaves can be drawn
  bool has_transparency = false;             ///< leaves that have been resident are transparent
  HookArray<Buffer> pages;                   ///< [page] null if it is not resident
  BoundedList<std::uint32_t> leaf_textures;  ///< those that its cards use, kNoTexture included; distinct
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
  /// All of them outlive this object.
  PlantStore(Device& device, DeferredDeletion& deletion, Uploads& uploads, const TextureSets& texture_sets,
             const coppice_allocator& allocator)
      : device_(device), deletion_(deletion), uploads_(uploads), texture_sets_(texture_sets), allocator_(allocator) {}
  /// The GPU must be done with everything.
  ~PlantStore();
  PlantStore(const PlantStore&) = delete;
  PlantStore& operator=(const PlantStore&) = delete;

  /// Creates the placeholder. errors  out_of_memory
  Result<void> create();
  /// Reserves memory for this many plants. errors  out_of_memory; nothing has changed
  Result<void> reserve(std::uint32_t count);
  /// Counts up to the last plant that was ever added.
  [[nodiscard]] std::uint32_t count() const { return count_; }
  /// Null if there is none.
  [[nodiscard]] const StoredPlant* plant(std::uint32_t index) const { return plants_[index].get(); }
  /// A white texture of 1 x 1.
  [[nodiscard]] const StoredTexture& placeholder() const { return placeholder_; }
  /// The plant's texture, or the placeholder if it is not resident.
  [[nodiscard]] const StoredTexture& shown_texture(std::uint32_t plant, std::uint32_t texture) const;

  /// index: reserved, and not in use. lod_words: pack_lod_table of the file. errors  out_of_memory
  Result<void> add(std::uint32_t index, const PlantFile& file, const PlantAppearance& appearance, std::span<const std::uint32_t> lod_words);
  /// Before: the GPU has finished the last frame that drew the plant, and its chunks have been dropped. Its tables may still be uploading.
  void remove(std::uint32_t index);

  /// errors  out_of_memory: the chunk is not resident
  Result<void> upload_page(const PageUpload& upload);

  /// Means all of a chunk.
  static constexpr std::uint64_t kWhole = ~std::uint64_t{0};
  // The next two copy at most about max_bytes of a chunk, and return true once it is whole. Further calls for the same chunk go on from
  // there, in the same frame or in a later one; meanwhile no other chunk may be uploaded in parts.

  /// errors  out_of_memory: the chunk is not resident
  Result<bool> upload_mesh(const MeshUpload& upload, std::uint64_t max_bytes = kWhole);
  /// bytes: a TEXTURE chunk. errors  bad_file: the field and its offset; unsupported: the device does not take blocks; out_of_memory
  Result<bool> upload_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> bytes,
                              std::uint64_t max_bytes = kWhole);
  /// Forgets the chunk that is being uploaded in parts, if there is one.
  void abandon_upload();
  /// Uploads the tables of plants that were added, and the placeholder. words: the packed tables, kTableStride a plant. errors
  /// out_of_memory: the rest waits
  Result<void> upload_tables(const Buffer& words);

  /// Before: the GPU has finished the last frame that drew the chunk.
  void drop_page(std::uint32_t plant, std::uint32_t page);
  /// mesh: as MeshUpload::mesh
  void drop_mesh(std::uint32_t plant, std::uint32_t mesh);
  void drop_texture(std::uint32_t plant, std::uint32_t texture);
  /// Stops drawing with the texture; drop_texture follows when the GPU is done with it.
  void hide_texture(std::uint32_t plant, std::uint32_t texture) { plants_[plant]->textures[texture].visible = false; }

 private:
  Result<void> fill_tables(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance);
  Result<void> add_single_leaf(StoredPlant& plant, const PlantFile& file, const PlantAppearance& appearance);
  Result<void> patch_tables(StoredPlant& plant, std::uint64_t offset, std::span<const std::uint8_t> bytes);
  Result<void> patch_cuts(StoredPlant& plant, ReadyCuts& cuts);
  /// A chunk of which a part has been copied.
  struct PartialUpload {
    Buffer buffer;
    StoredTexture texture;
    std::uint64_t copied_bytes = 0;
  };
  void abandon(PartialUpload& upload);
  /// errors  as upload_mesh; the upload has been abandoned
  Result<bool> continue_mesh(PartialUpload& part, const MeshUpload& upload, std::uint64_t max_bytes);
  Result<bool> continue_texture(PartialUpload& part, std::span<const std::uint8_t> bytes, std::uint64_t max_bytes);
  /// Creates a buffer and lets `stage` stage its contents; undoes both on failure.
  template <class Stage>
  Result<void> upload(Buffer& place, const BufferDesc& desc, Stage stage);
  void destroy(StoredPlant& plant);
  void destroy(StoredTexture& texture);

  Device& device_;
  DeferredDeletion& deletion_;
  Uploads& uploads_;
  const TextureSets& texture_sets_;
  coppice_allocator allocator_;
  HookArray<std::unique_ptr<StoredPlant>> plants_;
  std::uint32_t count_ = 0;
  StoredTexture placeholder_;  ///< visible once its texel is being uploaded
  PartialUpload partial_;
};

}  // namespace coppice::gpu
