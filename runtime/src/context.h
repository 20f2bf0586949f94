#pragma once

// A context: the streamer, the backend that takes what it reads, the instances, and the order in which a frame moves data between them. It
// does not check arguments; api.cpp has done so.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "backend.h"
#include "coppice/coppice.h"
#include "demand.h"
#include "eye_motion.h"
#include "handle.h"
#include "hooks.h"
#include "instances.h"
#include "leaf_budget.h"
#include "ledger.h"
#include "open_scene.h"
#include "result.h"
#include "scene_stream.h"
#include "streamer.h"

namespace coppice {

/// Arguments of a context's creation: the checked desc, and copies of its hooks. The desc's own pointers to hooks are not used.
struct ContextOptions {
  coppice_context_desc desc{};
  Hooks hooks;
};

/// An array of draws in the program's memory.
struct DrawOutput {
  coppice_draw* draws = nullptr;
  std::uint32_t capacity = 0, draw_bytes = 0;
};

class Context {
 public:
  /// errors  the backend's; out_of_memory; invalid_argument: an incomplete hook, a budget below what the context takes
  static Result<std::unique_ptr<Context>> create(const ContextOptions& options, const MakeBackend& make_backend);

  /// Memory that a context takes before any plant, as its budget counts it. Allocates no device memory, and calls no hook but the log.
  /// add_views: adds views to the backend, and returns the bytes of their pictures. instances: that will be added
  /// errors: as create, but not for the budget; those of add_views
  using AddViews = std::function<Result<std::uint64_t>(Backend& backend)>;
  static Result<std::uint64_t> cost(const ContextOptions& options, const MakeBackend& make_backend, const AddViews& add_views = {},
                                    std::uint32_t instances = 0);

  /// The tag in its handles, from 1 on; a context shares it with the 4,095th one created after it.
  [[nodiscard]] std::uint32_t tag() const { return tag_; }
  /// errors  device_lost, now or earlier. Then nothing more may be recorded
  [[nodiscard]] Result<void> device_state() const { return backend_->device_state(); }
  [[nodiscard]] const BackendLimits& limits() const { return std::as_const(*backend_).limits(); }
  [[nodiscard]] gpu::Renderer* renderer() const { return backend_->renderer(); }

  /// errors  invalid_argument: less than the context takes at least; the error names that
  Result<void> set_memory_budget(std::uint64_t bytes);
  /// errors  as set_memory_budget
  Result<void> trim(std::uint64_t target_bytes);

  void retry_failed();

  /// errors  as coppice_plant_open, logged already
  Result<coppice_plant> open_plant(const PlantSource& source);
  /// Opens without waiting: begin_frame continues the work. errors  out_of_memory: max_plants are open; not logged
  Result<coppice_plant> start_open(const PlantSource& source);
  /// True also while it is being opened, and if that failed.
  [[nodiscard]] bool is_open(coppice_plant plant) const;
  /// plant: open, here and below
  [[nodiscard]] coppice_plant_state plant_state(coppice_plant plant) const { return entry(plant).state; }
  void close_plant(coppice_plant plant);
  /// The path or name that it was opened from, for messages.
  [[nodiscard]] const char* plant_path(coppice_plant plant) const { return streamer_->path(entry(plant).slot); }
  /// plant: ready. source: none for the plant's own. errors  as coppice_plant_reload, logged already
  Result<void> reload_plant(coppice_plant plant, const std::optional<PlantSource>& source);
  void fill_info(coppice_plant plant, coppice_plant_info& info) const;
  /// What of a plant may be drawn in this frame, and where the renderer has it; null if it is not open yet. before: upload
  [[nodiscard]] const LodPlant* drawn_plant(coppice_plant plant, std::uint32_t& slot) const;
  void set_override(coppice_plant plant, const std::optional<gpu::MaterialOverride>& material_override) {
    entry(plant).material_override = material_override;
  }

  /// errors  as coppice_scene_open; logged already
  Result<coppice_scene> open_scene(const char* path, const gpu::Pose& pose);
  [[nodiscard]] bool is_scene(coppice_scene scene) const;
  /// scene: is_scene
  [[nodiscard]] OpenScene* scene(coppice_scene scene) { return scenes_[unpack_handle(scene).index].scene.get(); }
  [[nodiscard]] const OpenScene* scene(coppice_scene scene) const { return scenes_[unpack_handle(scene).index].scene.get(); }
  void close_scene(coppice_scene scene);
  /// kNoPlant if it is not open or could not be opened. plant: any, also 0
  [[nodiscard]] std::uint32_t usable_slot(coppice_plant plant) const;
  /// 0 for kNoPlant.
  [[nodiscard]] coppice_plant plant_at(std::uint32_t slot) const;
  /// trees: of open scenes, present in their files. errors  out_of_memory; nothing has changed
  Result<void> change_trees(std::span<const coppice_scene_tree> trees, const TreeEdit& edit);
  /// out.scene: open. box: counts from the origin
  void query(const WorldBox& box, TreeOutput& out) const;
  /// tree: of an open scene, present in its file
  [[nodiscard]] coppice_tree_info tree_info(const coppice_scene_tree& tree) const;

  // In context_pick.cpp. ray: checked
  [[nodiscard]] coppice_hit pick(const coppice_ray& ray) const;

  Result<void> add_instances(coppice_plant plant, const gpu::PlacementRecords& placements, std::span<coppice_instance> handles);
  /// The place that the engine's coordinates count from.
  [[nodiscard]] const dvec3& origin() const { return instances_.origin(); }
  void set_origin(const dvec3& origin) { instances_.set_origin(origin); }
  [[nodiscard]] gpu::InstanceTable& instances() { return instances_; }
  [[nodiscard]] const gpu::InstanceTable& instances() const { return instances_; }
  /// Reserves memory for this many slots, for more if memory is free, and for copying them to the GPU in one frame. errors  out_of_memory;
  /// nothing has changed
  Result<void> grow_slots(std::uint32_t slots);
  /// plant: open
  [[nodiscard]] std::uint32_t plant_slot(coppice_plant plant) const { return entry(plant).slot; }

  [[nodiscard]] const Hooks& hooks() const { return hooks_.hooks; }
  [[nodiscard]] Ledger& ledger() { return ledger_; }
  /// Asks the ledger; returns its error if it refuses.
  Result<void> check_fits(std::uint64_t bytes);
  /// The folder that plants of scenes must be in.
  [[nodiscard]] const AssetFolder& scene_plants() const { return scene_plants_; }

  /// backend_view: the backend's index, which stays the caller's if this fails. errors  out_of_memory
  Result<coppice_view> create_view(const coppice_view_desc& desc, std::uint32_t backend_view);
  /// view: open, here and below
  void destroy_view(coppice_view view);
  [[nodiscard]] bool is_view(coppice_view view) const;
  /// Returns the camera of the sun's shadow map in the view. desc: checked
  [[nodiscard]] coppice_camera sun_camera(coppice_view view, const coppice_sun_desc& desc) const;
  [[nodiscard]] std::uint32_t backend_view(coppice_view view) const { return entry_of_view(view).backend_view; }
  [[nodiscard]] bool is_settled(coppice_view view) const;

  /// cameras: checked, each for another view. errors  device_lost, here and below; invalid_argument: a projection in which nothing is
  /// visible, or frame numbers that do not grow
  Result<void> begin_frame(const coppice_frame& frame, std::span<const coppice_camera> cameras);
  /// Gives decoded chunks and changed instances to the backend.
  Result<void> upload();
  /// The progress of the frame's recording: each step needs the one before it in the same frame.
  enum class Recording : std::uint8_t { none, begun, uploaded };
  [[nodiscard]] Recording recording() const { return recording_; }

  // In context_host.cpp, for a program that draws by itself: renderer() is null.
  [[nodiscard]] coppice_change next_change();
  /// errors  invalid_argument: the chunk does not wait for this outcome
  Result<void> acknowledge(ChunkId id, coppice_outcome outcome);

  // In context_host.cpp, for any backend.

  /// True if it is the file of an open plant.
  [[nodiscard]] bool is_file(std::uint32_t file) const { return file < slots_.count && slots_[file].open; }
  /// file: is_file, here and below
  [[nodiscard]] const PlantFile& file(std::uint32_t file) const { return streamer_->file(file); }
  [[nodiscard]] coppice_file_info file_info(std::uint32_t file) const;
  [[nodiscard]] coppice_material material(std::uint32_t file, std::uint32_t index) const;
  [[nodiscard]] coppice_card card(std::uint32_t file, std::uint32_t index) const;
  /// True if the last frame had a camera for it.
  [[nodiscard]] bool is_shown(coppice_view view) const { return frame_number_ > 0 && entry_of_view(view).shown_frame == frame_number_; }
  /// Returns the number of draws. view: is_shown. Thread: calls for different views may overlap
  std::uint32_t draws(coppice_view view, const DrawOutput& out);
  /// Rounds to a whole cut, limited to what is resident.
  [[nodiscard]] std::uint32_t whole_cut(std::uint32_t file, float leaf_count) const;
  /// leaf_count: from whole_cut. layout: checked. output: large enough
  void write_leaves(std::uint32_t file, std::uint32_t leaf_count, const coppice_leaf_layout& layout,
                    const coppice_leaf_output& output) const;

  void fill_stats(coppice_stats& stats) const;
  void fill_stats(coppice_view view, coppice_view_stats& stats) const;
  [[nodiscard]] const coppice_log& log() const { return hooks_.hooks.log; }

 private:
  /// An open file; its index is the same in the streamer, the backend and the instances.
  struct PlantSlot {
    bool open = false;
    coppice_plant plant = 0;  ///< the plant whose file it is or was
    bool in_backend = false;  ///< in the backend; outlives `open` until the GPU is done
  };
  /// The object behind a plant's handle.
  struct PlantEntry {
    std::uint32_t generation = 0;
    bool open = false;
    coppice_plant_state state = COPPICE_PLANT_READY;
    Status failure = Status::ok;        ///< the reason of a failed state
    std::uint32_t slot = 0;             ///< no slot if it failed
    std::uint32_t next_slot = kNoSlot;  ///< the slot that it is being reloaded into
    std::optional<gpu::MaterialOverride> material_override;
    std::uint64_t swap_frame = 0;  ///< reloading: from this frame on the new file is shown, however much of it is resident
  };
  struct SceneEntry {
    std::unique_ptr<OpenScene> scene;  ///< null: not open
    std::uint32_t generation = 0;
  };
  static constexpr std::uint32_t kNoSlot = 0xffffffffu;
  struct ViewEntry {
    std::uint32_t generation = 0;
    bool open = false;
    std::uint32_t backend_view = 0;
    std::size_t group = 0;          ///< its view group
    std::uint64_t shown_frame = 0;  ///< the last frame with a camera for it
    LodView shown;                  ///< as in that frame
    ViewCounts counts;              ///< those of the last get_draws
    LeafBudget budget;
    DemandAhead ahead;
  };

  /// A ray that starts where it enters an instance's sphere; m, from the world's first origin. direction: unit
  struct PickRay {
    dvec3 start_m{0, 0, 0};
    vec3 direction{0, 0, -1};
    bool boxes = false;
  };
  struct PlantHit {
    coppice_hit_kind kind = COPPICE_HIT_NOTHING;
    float t_m = 0;
  };

  Context() = default;
  [[nodiscard]] PlantHit hit_of(std::uint32_t slot, const PickRay& from) const;
  [[nodiscard]] coppice_scene scene_handle(std::uint32_t index) const;
  /// The tree in a slot; none for an instance with a handle.
  [[nodiscard]] coppice_scene_tree tree_at(std::uint32_t slot) const;
  [[nodiscard]] const PlantEntry& entry(coppice_plant plant) const { return plants_[unpack_handle(plant).index]; }
  [[nodiscard]] PlantEntry& entry(coppice_plant plant) { return plants_[unpack_handle(plant).index]; }
  Result<std::uint32_t> open_slot(const PlantSource& source);
  /// max_plants_ if all are in use.
  [[nodiscard]] std::uint32_t free_entry() const;
  /// Gives a plant that the streamer has opened to the backend. errors  out_of_memory; logged, and the slot is closed
  Result<void> show_slot(std::uint32_t slot);
  /// Makes a handle for it. before: free_entry() is not max_plants_
  coppice_plant take_entry(std::uint32_t slot, coppice_plant_state state);
  /// Adds the slot to the lists by slot; grow_plants has reserved the memory.
  void add_slot(std::uint32_t slot);
  /// Reserves memory for this many slots. errors  out_of_memory; only capacities may have grown
  Result<void> reserve_host(std::uint32_t count);
  [[nodiscard]] std::uint64_t host_bytes() const;
  /// Continues with plants that are being opened. Those that are read take about streaming_ms, but at least one is handled.
  void finish_openings();
  void close_slot(std::uint32_t slot);
  void remove_instances(std::uint32_t slot);
  /// Shows the new files of plants that have reloaded far enough.
  void finish_reloads();
  /// Reserves memory for one more plant. errors  out_of_memory; no plant was added
  Result<void> grow_plants();
  Result<void> upload_decoded();
  /// Copies at most about max_bytes of a chunk. True if it is whole, or has failed. errors  device_lost, here and below
  Result<bool> upload_part(const DecodedChunk& chunk, std::uint64_t max_bytes);
  /// Copies parts of uploading_ until the time, but at least one.
  Result<void> continue_upload(std::uint64_t until_ns);
  /// Gives up the upload of a plant that has been closed since.
  void abandon_closed_upload();
  /// Stores what is resident of the plants, for draws.
  void note_residency();
  void note_residency(std::uint32_t slot);
  /// Tells a program that draws by itself that a slot has opened.
  void tell_opened(std::uint32_t slot) { backend_->tell({COPPICE_CHANGE_PLANT_OPENED, slots_[slot].plant, {.plant = slot}}); }
  [[nodiscard]] ViewEntry& entry_of_view(coppice_view view) { return views_[unpack_handle(view).index]; }
  [[nodiscard]] const ViewEntry& entry_of_view(coppice_view view) const { return views_[unpack_handle(view).index]; }
  [[nodiscard]] std::size_t smallest_group() const;
  /// What the backend has drawn, or the program has asked for with draws().
  [[nodiscard]] ViewCounts counts_of(const ViewEntry& view) const;
  /// lod: with its own threshold; afterwards with that of streaming
  void show_view(const coppice_camera& camera, LodView& lod);
  void measure_views(std::span<const coppice_camera> cameras, std::span<const LodView> lods);
  [[nodiscard]] StreamFrame stream_frame() const;
  /// errors  invalid_argument: frame_number or completed_number
  [[nodiscard]] Result<void> check_numbers(const coppice_frame& frame) const;
  /// Number of instance slots that shrink() leaves.
  [[nodiscard]] std::uint32_t shrunk_slots();
  /// Memory that the context takes at least under a budget, with space for so many instance slots: with pinned chunks only, and unless
  /// slots are added in buffers as small as possible and without pictures.
  [[nodiscard]] std::uint64_t least_bytes(std::uint64_t budget_bytes, std::uint32_t slots);
  /// Returns the least budget, from `bytes` on, that holds what the context then takes at least.
  [[nodiscard]] std::uint64_t least_budget(std::uint64_t bytes, std::uint32_t slots);
  /// errors  `status`: bytes are below `least`
  [[nodiscard]] static Result<void> check_budget(std::uint64_t bytes, std::uint64_t least, Status status = Status::invalid_argument);
  /// Gives memory back that is reserved for more than there is. False: try again in the next frame
  [[nodiscard]] bool shrink();
  void start_shrinking();
  /// Goes on with set_memory_budget and trim.
  void continue_shrinking();

  HookSet hooks_;
  Ledger ledger_;  ///< has no budget while the context is created
  AssetFolder scene_plants_;
  std::unique_ptr<Backend> backend_;
  gpu::InstanceTable instances_;
  // Lists reach to the last plant that was ever used, so unused ones cost nothing in a frame.
  BoundedList<PlantEntry> plants_;  ///< at most [max_plants_]
  BoundedList<PlantSlot> slots_;    ///< at most [max_plants_ + kReloadSlots]
  std::uint32_t max_plants_ = 0;
  std::array<BoundedList<PlantDemand>, kMaxViewGroups> demands_;  ///< by view group
  GroupViews group_views_;                                        ///< those of the frame
  std::vector<ViewEntry> views_;
  std::vector<LodView> lods_;         ///< those of the frame's views
  BoundedList<LodPlant> lod_plants_;  ///< by slot: for draws
  std::array<SceneEntry, COPPICE_MAX_SCENES> scenes_;
  std::uint32_t tag_ = 0;
  std::uint64_t budget_bytes_ = 0;       ///< the ledger's, but while trim is at work
  std::uint64_t trim_end_frame_ = 0;     ///< trim gives up in this frame; 0: it is not at work
  bool shrinks_ = false;                 ///< shrink() has more to do
  std::uint64_t slot_upload_bytes_ = 0;  ///< reserved until new slots are copied to the GPU
  std::uint64_t frame_number_ = 0, completed_number_ = 0;
  PlacedWind wind_;                ///< the last frame's, without its map; none before
  float wind_reach_share_ = 0.0f;  ///< PlacedWind::reach_share, of all plants that were open
  Recording recording_ = Recording::none;
  std::optional<DecodedChunk> uploading_;  ///< the chunk that is being uploaded in parts
  float prefetch_frames_ = 0;              ///< how far ahead of the camera streaming looks, frames
  std::uint64_t streaming_ns_ = 0;         ///< time per frame for taking over chunks
  std::unique_ptr<Streamer> streamer_;     ///< last: its destructor waits for jobs that use the rest
};

}  // namespace coppice
