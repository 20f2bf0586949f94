#pragma once

// One context: the streamer, the backend that takes what it reads, and the instances, and the order in which a frame moves things between
// them. No checks of what the engine passes: api.cpp has made them.

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
#include "hooks.h"
#include "instances.h"
#include "leaf_budget.h"
#include "ledger.h"
#include "open_scene.h"
#include "result.h"
#include "scene_stream.h"
#include "streamer.h"

namespace coppice {

/// What a context is created with: the desc, checked, and the hooks that it points at. The desc's own pointers to hooks are not used.
struct ContextOptions {
  coppice_context_desc desc{};
  Hooks hooks;
};

/// Draws as a program has them.
struct DrawOutput {
  coppice_draw* draws = nullptr;
  std::uint32_t capacity = 0, draw_bytes = 0;
};

class Context {
 public:
  /// errors  the backend's; out_of_memory; invalid_argument: a hook set in part, a budget below what the context takes
  static Result<std::unique_ptr<Context>> create(const ContextOptions& options, const MakeBackend& make_backend);

  /// What a context takes before any plant, as its budget counts it; takes no device memory itself, and calls no hook but the log. errors
  /// as create, but for the budget
  static Result<std::uint64_t> cost(const ContextOptions& options, const MakeBackend& make_backend);

  /// Of its handles, 1 and on; contexts that are created 4,095 after each other share one.
  [[nodiscard]] std::uint32_t tag() const { return tag_; }
  /// errors  device_lost, now or earlier. Then nothing more may be recorded
  [[nodiscard]] Result<void> device_state() const { return backend_->device_state(); }
  [[nodiscard]] const BackendLimits& limits() const { return std::as_const(*backend_).limits(); }
  [[nodiscard]] gpu::Renderer* renderer() const { return backend_->renderer(); }

  /// errors  invalid_argument: less than the context took when it was created
  Result<void> set_memory_budget(std::uint64_t bytes);

  /// errors  as coppice_plant_open, logged already
  Result<coppice_plant> open_plant(const PlantSource& source);
  /// Without waiting: begin_frame goes on with it. errors  out_of_memory: max_plants are open; not logged
  Result<coppice_plant> start_open(const PlantSource& source);
  /// Also while it is being opened and where that failed.
  [[nodiscard]] bool is_open(coppice_plant plant) const;
  /// plant: open, here and below
  [[nodiscard]] coppice_plant_state plant_state(coppice_plant plant) const { return entry(plant).state; }
  void close_plant(coppice_plant plant);
  /// What it was opened from, for messages.
  [[nodiscard]] const char* plant_path(coppice_plant plant) const { return streamer_->path(entry(plant).slot); }
  /// plant: ready. source  none: what it was opened from. errors  as coppice_plant_reload, logged already
  Result<void> reload_plant(coppice_plant plant, const std::optional<PlantSource>& source);
  void fill_info(coppice_plant plant, coppice_plant_info& info) const;

  /// errors  as coppice_scene_open; logged already
  Result<coppice_scene> open_scene(const char* path, const gpu::Pose& pose);
  [[nodiscard]] bool is_scene(coppice_scene scene) const;
  /// scene: is_scene
  [[nodiscard]] OpenScene* scene(coppice_scene scene);
  [[nodiscard]] const OpenScene* scene(coppice_scene scene) const;
  void close_scene(coppice_scene scene);
  /// kNoPlant: it is not open, or could not be opened. plant: any, 0 too
  [[nodiscard]] std::uint32_t usable_slot(coppice_plant plant) const;
  /// 0 of kNoPlant.
  [[nodiscard]] coppice_plant plant_at(std::uint32_t slot) const;
  /// trees: of open scenes, which their files have. errors  out_of_memory; nothing has changed
  Result<void> change_trees(std::span<const coppice_scene_tree> trees, const TreeEdit& edit);
  /// out.scene: open. box: counts from the origin
  void query(const WorldBox& box, TreeOutput& out) const;
  /// tree: of an open scene, which its file has
  [[nodiscard]] coppice_tree_info tree_info(const coppice_scene_tree& tree) const;

  // context_pick.cpp. ray: checked
  [[nodiscard]] coppice_hit pick(const coppice_ray& ray) const;

  Result<void> add_instances(coppice_plant plant, const gpu::PlacementRecords& placements, std::span<coppice_instance> handles);
  /// What the engine's coordinates count from.
  [[nodiscard]] const dvec3& origin() const { return instances_.origin(); }
  void set_origin(const dvec3& origin) { instances_.set_origin(origin); }
  [[nodiscard]] gpu::InstanceTable& instances() { return instances_; }
  [[nodiscard]] const gpu::InstanceTable& instances() const { return instances_; }
  /// Room for so many slots, for more where that is free, and for bringing them to the GPU in one frame. errors  out_of_memory; nothing has
  /// changed
  Result<void> grow_slots(std::uint32_t slots);
  /// plant: open
  [[nodiscard]] std::uint32_t plant_slot(coppice_plant plant) const { return entry(plant).slot; }

  [[nodiscard]] const Hooks& hooks() const { return hooks_.hooks; }
  [[nodiscard]] Ledger& ledger() { return ledger_; }
  /// The ledger's, or why it refused them.
  Result<void> check_fits(std::uint64_t bytes);
  /// Where plants of scenes may be.
  [[nodiscard]] const AssetFolder& scene_plants() const { return scene_plants_; }

  /// backend_view: the backend's index of it, which stays the caller's where this fails. errors  out_of_memory
  Result<coppice_view> create_view(const coppice_view_desc& desc, std::uint32_t backend_view);
  /// view: open, here and below
  void destroy_view(coppice_view view);
  [[nodiscard]] bool is_view(coppice_view view) const;
  [[nodiscard]] bool has_reversed_depth(coppice_view view) const;
  [[nodiscard]] std::uint32_t backend_view(coppice_view view) const { return entry_of_view(view).backend_view; }
  [[nodiscard]] bool is_settled(coppice_view view) const;

  /// cameras: checked, each of another view. errors  device_lost, here and below; invalid_argument: a projection that nothing can be seen
  /// with, or frame numbers that do not grow
  Result<void> begin_frame(const coppice_frame& frame, std::span<const coppice_camera> cameras);
  /// Gives the backend what was decoded, and what has changed of instances.
  Result<void> upload();
  /// How far the frame's recording has come: each step needs the one before it in the same frame.
  enum class Recording : std::uint8_t { none, begun, uploaded };
  [[nodiscard]] Recording recording() const { return recording_; }

  // context_host.cpp. The backend's host(): not null
  [[nodiscard]] coppice_change next_change();
  /// errors  invalid_argument: the chunk does not wait for it
  Result<void> confirm(ChunkId id, coppice_outcome outcome);

  // context_host.cpp, of any backend.
  /// Whether it is one of an open plant.
  [[nodiscard]] bool is_file(std::uint32_t file) const { return file < slots_.count && slots_[file].open; }
  /// file: is_file, here and below
  [[nodiscard]] const PlantFile& file(std::uint32_t file) const { return streamer_->file(file); }
  [[nodiscard]] coppice_file_info file_info(std::uint32_t file) const;
  [[nodiscard]] coppice_material material(std::uint32_t file, std::uint32_t index) const;
  [[nodiscard]] coppice_card card(std::uint32_t file, std::uint32_t index) const;
  /// Whether the last frame had a camera of it.
  [[nodiscard]] bool is_shown(coppice_view view) const { return frame_number_ > 0 && entry_of_view(view).shown_frame == frame_number_; }
  /// Returns how many there are. view: is_shown. Thread: those of different views may overlap
  std::uint32_t draws(coppice_view view, const DrawOutput& out);
  /// The whole cut of a fractional one, as far as it is there.
  [[nodiscard]] std::uint32_t whole_cut(std::uint32_t file, float leaf_count) const;
  /// leaf_count: of whole_cut. layout: checked. output: with room for it
  void write_leaves(std::uint32_t file, std::uint32_t leaf_count, const coppice_leaf_layout& layout,
                    const coppice_leaf_output& output) const;

  void fill_stats(coppice_stats& stats) const;
  void fill_stats(coppice_view view, coppice_view_stats& stats) const;
  [[nodiscard]] const coppice_log& log() const { return hooks_.hooks.log; }

 private:
  /// An open file: an index of the streamer, the backend and the instances.
  struct PlantSlot {
    bool open = false;
    coppice_plant plant = 0;  ///< whose it is or was
    bool in_backend = false;  ///< in the backend; outlives `open` until the GPU is done
  };
  /// What the engine holds a handle of.
  struct PlantEntry {
    std::uint32_t generation = 0;
    bool open = false;
    coppice_plant_state state = COPPICE_PLANT_READY;
    Status failure = Status::ok;        ///< of the state
    std::uint32_t slot = 0;             ///< none where it failed
    std::uint32_t next_slot = kNoSlot;  ///< being reloaded into
    std::uint64_t swap_frame = 0;       ///< reloading: from this frame on what is there of the new file has to do
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
    std::size_t lens = 0;           ///< which of streaming's
    std::uint64_t shown_frame = 0;  ///< that had a camera of it
    LodView shown;                  ///< in that frame
    ViewCounts counts;              ///< a host's: of its last get_draws
    LeafBudget budget;
    DemandAhead ahead;
  };

  /// From where it enters an instance's sphere, m, from the world's first origin. direction: unit
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
  /// Of what is in a slot; none of an instance by handle.
  [[nodiscard]] coppice_scene_tree tree_at(std::uint32_t slot) const;
  [[nodiscard]] const PlantEntry& entry(coppice_plant plant) const;
  [[nodiscard]] PlantEntry& entry(coppice_plant plant);
  Result<std::uint32_t> open_slot(const PlantSource& source);
  /// max_plants_ where all are open.
  [[nodiscard]] std::uint32_t free_entry() const;
  /// Gives what the streamer has opened to the backend. errors  out_of_memory; logged, and the slot is closed
  Result<void> show_slot(std::uint32_t slot);
  /// A handle for it. free_entry() is not max_plants_
  coppice_plant take_entry(std::uint32_t slot, coppice_plant_state state);
  /// Its place in what is kept by slot; grow_plants has made room.
  void add_slot(std::uint32_t slot);
  /// Room for so many slots. errors  out_of_memory; nothing that counts has changed
  Result<void> reserve_host(std::uint32_t count);
  [[nodiscard]] std::uint64_t host_bytes() const;
  /// Goes on with plants that are being opened; for about streaming_ms with those that are read, one at least.
  void finish_openings();
  void close_slot(std::uint32_t slot);
  void remove_instances(std::uint32_t slot);
  /// Shows the new files of plants whose reload has come far enough.
  void finish_reloads();
  /// Room for one more plant. errors  out_of_memory; no plant is there that was not
  Result<void> grow_plants();
  Result<void> upload_decoded();
  /// What of the plants is there, for draws.
  void note_residency();
  void note_residency(std::uint32_t slot);
  /// For next_change, if a host draws.
  void tell_host(coppice_change_kind kind, ChunkId id);
  [[nodiscard]] coppice_change change_of(const DecodedChunk& chunk) const;
  [[nodiscard]] ViewEntry& entry_of_view(coppice_view view);
  [[nodiscard]] const ViewEntry& entry_of_view(coppice_view view) const;
  [[nodiscard]] std::size_t free_lens() const;
  /// draws() has counted them for a host.
  [[nodiscard]] ViewCounts counts_of(const ViewEntry& view) const;
  /// lod: with its own threshold; afterwards with that which streaming goes by
  void show_view(const coppice_camera& camera, LodView& lod);
  void measure_views(std::span<const coppice_camera> cameras, std::span<const LodView> lods);
  [[nodiscard]] StreamFrame stream_frame() const;
  /// errors  invalid_argument: frame_number or completed_number
  [[nodiscard]] Result<void> check_numbers(const coppice_frame& frame) const;
  /// What it takes before any plant. errors  invalid_argument: the budget is below it
  [[nodiscard]] Result<void> check_budget(std::uint64_t bytes) const;

  HookSet hooks_;
  Ledger ledger_;  ///< without a budget while the context is created
  AssetFolder scene_plants_;
  std::unique_ptr<Backend> backend_;
  gpu::InstanceTable instances_;
  // Up to the last that was ever used: what was never used costs nothing in a frame.
  BoundedList<PlantEntry> plants_;  ///< [max_plants_] at most
  BoundedList<PlantSlot> slots_;    ///< [max_plants_ + kReloadSlots] at most
  std::uint32_t max_plants_ = 0;
  std::array<BoundedList<PlantDemand>, kMostLenses> demands_;  ///< by lens
  LensViews lenses_;                                           ///< of the frame
  std::vector<ViewEntry> views_;
  std::vector<LodView> lods_;  ///< of the frame's views
  BoundedList<gpu::PlantResidency> residency_;
  BoundedList<LodPlant> lod_plants_;  ///< by slot: the same for selection on the CPU
  std::array<SceneEntry, COPPICE_MAX_SCENES> scenes_;
  std::uint32_t tag_ = 0;
  std::uint64_t least_budget_bytes_ = 0;
  std::uint64_t slot_upload_bytes_ = 0;  ///< taken until new slots are brought to the GPU
  std::uint64_t frame_number_ = 0, completed_number_ = 0;
  PlacedWind wind_;  ///< of the last frame, without its map; none before
  Recording recording_ = Recording::none;
  float prefetch_frames_ = 0;           ///< how far ahead of the camera streaming looks
  std::uint64_t streaming_ns_ = 0;      ///< a frame's time for taking over chunks
  std::unique_ptr<Streamer> streamer_;  ///< last: its destructor waits for jobs that use the rest
};

}  // namespace coppice
