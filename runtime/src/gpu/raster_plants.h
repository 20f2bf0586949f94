#pragma once

// Which lists the compute rasteriser has of each plant, on the device and on the way there. Lists are built as pages arrive, by one job at
// a time of a bounded number of leaves, and dropped with the pages they came from. Thread: externally serialised.

#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "card_looks.h"
#include "convert.h"
#include "crown_light.h"
#include "device.h"
#include "leaf_lists.h"
#include "list_build.h"
#include "raster_shared.h"
#include "reader.h"
#include "resources.h"
#include "result.h"

namespace coppice::gpu {

/// Bytes for the renderer to stage into a buffer.
struct RasterCopy {
  VkBuffer to = VK_NULL_HANDLE;
  std::uint64_t offset = 0;
  std::vector<std::uint8_t> bytes;
};

/// What lists may take.
struct RasterRoom {
  std::uint64_t device_bytes = 0;  ///< what a job keeps now is free again once it is taken over
  std::uint64_t ring_bytes = 0;    ///< of the staging ring; what does not fit there takes its bytes twice
};

class RasterPlants {
 public:
  /// device, garbage: outlive this object. jobs: where lists are built; without a hook, inside update
  /// errors  out_of_memory
  Result<void> create(Device& device, Garbage& garbage, std::uint32_t max_plants, const coppice_jobs& jobs);
  /// The GPU must be done with everything.
  void destroy();

  /// errors  out_of_memory
  Result<void> add_plant(std::uint32_t plant, const PlantFile& file);
  void remove_plant(std::uint32_t plant, std::uint64_t last_frame);
  /// nodes: 2 * COPPICE_PAGE_SPLITS * page + 1 and on; held until hide_page, or until a job is done with them
  void add_page(std::uint32_t plant, std::uint32_t page, SharedNodes nodes);
  /// Its lists stay until drop_page.
  void hide_page(std::uint32_t plant, std::uint32_t page);
  /// Measured from page 0, before add_page has it. A plant without pages needs none.
  void set_light(std::uint32_t plant, CrownLight light);
  void drop_page(std::uint32_t plant, std::uint32_t page, std::uint64_t last_frame);
  /// What add_wood or add_leaf_mesh takes until it is on the device, at most.
  static std::uint64_t wood_bytes(const WoodMesh& mesh);
  void add_wood(std::uint32_t plant, std::uint32_t lod, const WoodMesh& mesh);
  void drop_wood(std::uint32_t plant, std::uint32_t lod, std::uint64_t last_frame);
  void add_leaf_mesh(std::uint32_t plant, std::uint32_t chunk, const WoodMesh& mesh);
  void drop_leaf_mesh(std::uint32_t plant, std::uint32_t chunk, std::uint64_t last_frame);
  /// chunk: one that read_texture takes
  void add_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> chunk);

  /// Takes over what the last job built, starts one for what is missing of cuts of up to leaf_counts[plant] leaves (0: none), and says in
  /// copies() what to copy. Small lists are built at once: a plant can be drawn from afar as soon as it is there. Where memory is short
  /// lists stay away: coarser ones are drawn, or, without any, the hardware draws.
  void update(std::span<const std::uint32_t> leaf_counts, RasterRoom room);
  /// What is kept for lists of the job of the last update, in bytes().
  [[nodiscard]] std::uint64_t kept_bytes() const { return job_.kept_bytes(); }
  /// Buffers of lists that a job builds; once 0 after an update, later updates with the same leaf counts and no more room add nothing.
  [[nodiscard]] std::uint32_t lists_in_flight() const { return static_cast<std::uint32_t>(job_.builds().size()); }
  /// Room for what the next update builds.
  [[nodiscard]] std::uint64_t wanted_bytes() const;
  /// What has to reach the device before the next frame is drawn, each place once; the caller removes what it has staged.
  std::vector<RasterCopy>& copies() { return copies_; }

  [[nodiscard]] VkBuffer lists() const { return lists_.buffer; }
  /// Of the plant's RasterList[kRasterLists].
  [[nodiscard]] uvec2 lists_address(std::uint32_t plant) const {
    return gpu_address(lists_.address + std::uint64_t{plant} * kRasterLists * sizeof(RasterList));
  }
  /// Whether the rasteriser draws the plant's leaves, as of the last update.
  [[nodiscard]] bool has_lists(std::uint32_t plant) const { return plants_[plant].record.level_count > 0; }
  [[nodiscard]] VkBuffer plants() const { return plants_buffer_.buffer; }
  /// CPU memory.
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr std::uint32_t kMeshLists = kRasterLists - kRasterLevels;
  /// Lists that share a buffer; rungs of the ladder from `first` on.
  struct Batch {
    Buffer buffer;
    std::uint32_t first = 0;
    std::uint32_t finest_leaf_count = 0;
  };
  /// A wood LoD or a chunk of leaf meshes: list kRasterLevels on.
  struct MeshList {
    WoodMesh waiting;                   ///< for the light, its textures, room or a job
    std::set<std::uint32_t> materials;  ///< whose textures it waits for
    bool building = false;
    Buffer buffer;
  };
  struct PlantLists {
    bool used = false;
    std::uint64_t generation = 0;  ///< tells it from plants that had its place before
    bool changed = true;           ///< headers, to be copied; once of every slot, so that none is read as it was allocated
    bool looks_changed = false;
    ListSource source;
    bool lit = false;                 ///< source.light is what it stays
    std::vector<bool> texture_taken;  ///< [textures] into the looks
    PageNode root;
    std::vector<SharedNodes> pages;  ///< that are there, from the first on
    Buffer looks_buffer;
    std::vector<Batch> batches;
    bool cuts_building = false;
    std::vector<MeshList> meshes;  ///< [kMeshLists]
    std::uint32_t leaf_mesh_count = 0;
    std::vector<RasterList> headers;  ///< [kRasterLists]
    RasterPlant record{};
  };
  /// What a call may still build.
  struct Allowance {
    std::uint32_t most_leaves = 0;  ///< of a list
    std::uint64_t leaves = 0;       ///< of all; none is left away for going beyond it
    RasterRoom room;
  };

  void add_copy(VkBuffer to, std::uint64_t offset, std::vector<std::uint8_t> bytes);
  void retire(const Buffer& buffer, std::uint64_t last_frame);
  Result<Buffer> upload(ListBuild& build, std::span<RasterList> headers);
  bool take_room(RasterRoom& room, std::uint64_t list_bytes);
  [[nodiscard]] static ListBuild new_build(const PlantLists& plant, std::uint32_t index, std::uint32_t first);
  std::vector<ListBuild> gather(std::span<const std::uint32_t> leaf_counts, Allowance allowance);
  void gather_cuts(std::uint32_t index, std::uint32_t leaf_count, Allowance& allowance, std::vector<ListBuild>& builds);
  void gather_meshes(std::uint32_t index, Allowance& allowance, std::vector<ListBuild>& builds);
  void take_over(std::vector<ListBuild> builds, RasterRoom& room);
  void take_cuts(PlantLists& plant, ListBuild& build, RasterRoom& room);
  void take_mesh(PlantLists& plant, ListBuild& build, RasterRoom& room);
  static void fill_mesh_record(PlantLists& plant);
  void drop_mesh_list(std::uint32_t plant, std::uint32_t list, std::uint64_t last_frame);
  void drop_rungs(PlantLists& plant, std::uint32_t leaf_count, std::uint64_t last_frame);

  Device* device_ = nullptr;
  Garbage* garbage_ = nullptr;
  coppice_jobs jobs_{};
  std::vector<PlantLists> plants_;  ///< up to the last that was ever added
  std::uint64_t last_generation_ = 0;
  std::vector<RasterCopy> copies_;
  std::uint64_t lacking_bytes_ = 0;  ///< what the largest list that found no room in the last update takes
  Buffer lists_;                     ///< RasterList[max_plants * kRasterLists]
  Buffer plants_buffer_;             ///< RasterPlant[max_plants]
  ListJob job_;
};

}  // namespace coppice::gpu
