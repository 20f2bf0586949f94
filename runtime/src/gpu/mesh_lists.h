#pragma once

// Which wood LoDs and chunks of leaf meshes the compute rasteriser has as clusters, on the device and on the way there. They are built by
// one job at a time of a bounded number of triangles. Thread: externally serialised.

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "card_looks.h"
#include "convert.h"
#include "crown_light.h"
#include "device.h"
#include "mesh_build.h"
#include "reader.h"
#include "resources.h"
#include "result.h"

namespace coppice::gpu {

/// Bytes for the renderer to stage into a buffer.
struct MeshCopy {
  VkBuffer to = VK_NULL_HANDLE;
  std::uint64_t offset = 0;
  std::vector<std::uint8_t> bytes;
};

/// What lists may take.
struct MeshRoom {
  std::uint64_t device_bytes = 0;  ///< what a job keeps now is free again once it is taken over
  std::uint64_t ring_bytes = 0;    ///< of the staging ring; what does not fit there takes its bytes twice
};

/// Where a plant's ClusterList[kClusterLists] is.
struct ListPlace {
  VkBuffer buffer = VK_NULL_HANDLE;
  std::uint64_t offset = 0;
};

class MeshLists {
 public:
  /// device, garbage: outlive this object. jobs: where lists are built; without a hook, inside update
  MeshLists(Device& device, Garbage& garbage, const coppice_jobs& jobs) : device_(device), garbage_(garbage), jobs_(jobs) {}
  MeshLists(const MeshLists&) = delete;
  MeshLists& operator=(const MeshLists&) = delete;
  /// The GPU must be done with everything.
  ~MeshLists();

  /// errors  out_of_memory
  Result<void> add_plant(std::uint32_t plant, const PlantFile& file, const ListPlace& lists);
  void remove_plant(std::uint32_t plant, std::uint64_t last_frame);
  /// Nothing is built before.
  void set_light(std::uint32_t plant, std::shared_ptr<const CrownLight> light);
  /// What add_mesh takes until it is on the device, at most.
  static std::uint64_t mesh_bytes(const WoodMesh& mesh);
  /// list: kWoodLists or kMeshLists and on
  void add_mesh(std::uint32_t plant, std::uint32_t list, const WoodMesh& mesh);
  void drop_mesh(std::uint32_t plant, std::uint32_t list, std::uint64_t last_frame);
  /// chunk: one that read_texture takes
  void add_texture(std::uint32_t plant, std::uint32_t texture, std::span<const std::uint8_t> chunk);

  /// Takes over what the last job built, starts one for what is missing, and says in copies() what to copy. Where memory is short lists
  /// stay away: the hardware draws.
  void update(MeshRoom room);
  /// What the job of the last update keeps, in bytes().
  [[nodiscard]] std::uint64_t kept_bytes() const { return job_.kept_bytes(); }
  /// Lists that a job builds; once 0 after an update, later updates with no more room add nothing.
  [[nodiscard]] std::uint32_t lists_in_flight() const { return static_cast<std::uint32_t>(job_.count()); }
  /// Room for what the next update builds.
  [[nodiscard]] std::uint64_t wanted_bytes() const;
  /// What has to reach the device before the next frame is drawn, each place once; the caller removes what it has staged.
  std::vector<MeshCopy>& copies() { return copies_; }
  /// What of a plant's record is here, as of the last update.
  void fill_record(std::uint32_t plant, Plant& record) const;
  /// CPU memory.
  [[nodiscard]] std::size_t bytes() const;

 private:
  static constexpr std::uint32_t kLists = kClusterLists - kWoodLists;
  struct Mesh {
    WoodMesh waiting;                   ///< for the light, its textures, room or a job
    std::set<std::uint32_t> materials;  ///< whose textures it waits for
    bool building = false;
    Buffer buffer;
    ClusterList header{};
  };
  struct PlantMeshes {
    bool used = false;
    std::uint64_t generation = 0;  ///< tells it from plants that had its place before
    bool looks_changed = false;
    MeshSource source;                ///< light: null until it is known
    std::vector<bool> texture_taken;  ///< [textures] into the looks
    ListPlace lists;
    Buffer looks_buffer;  ///< CardLook[], then wood colours
    std::array<Mesh, kLists> meshes;
    std::uint32_t leaf_mesh_count = 0;
  };

  [[nodiscard]] Mesh& mesh(std::uint32_t plant, std::uint32_t list) { return plants_[plant].meshes[list - kWoodLists]; }
  void add_copy(VkBuffer to, std::uint64_t offset, std::vector<std::uint8_t> bytes);
  void retire(const Buffer& buffer, std::uint64_t last_frame);
  bool take_room(MeshRoom& room, std::uint64_t list_bytes);
  std::vector<MeshBuild> gather(MeshRoom room);
  void take_over(std::vector<MeshBuild> builds, MeshRoom& room);
  void take_mesh(MeshBuild& build, MeshRoom& room);

  Device& device_;
  Garbage& garbage_;
  coppice_jobs jobs_{};
  std::vector<PlantMeshes> plants_;  ///< up to the last that was ever added
  std::uint64_t last_generation_ = 0;
  std::vector<MeshCopy> copies_;
  std::uint64_t lacking_bytes_ = 0;  ///< what the largest list that found no room in the last update takes
  MeshJob job_;
};

}  // namespace coppice::gpu
