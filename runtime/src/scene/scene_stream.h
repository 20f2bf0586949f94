#pragma once

// Keeps the tiles of a scene that are in demand in memory. It reads them through the I/O hook, decodes them with the jobs hook and says
// which instances come and go. It knows neither plants nor instance slots: its owner opens the species and places the instances.
//
// Calls in a frame, on the caller's thread:
//   begin_frame    collects finished reads and decodes, chooses tiles, starts reads. Never blocks
//   dropped        remove these tiles' instances
//   next_species   then species_opened(): open this plant
//   next_ready     then placed() or refused(): add this tile's instances; all its species are open or have failed

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "asset_path.h"
#include "hooks.h"
#include "ledger.h"
#include "scene_reader.h"
#include "tile_selection.h"

namespace coppice {

struct SceneStreamOptions {
  float min_px = 1.0f;               ///< tiles whose largest plant is smaller on screen are not in demand; > 0
  std::uint32_t max_in_flight = 32;  ///< reads and decodes of tiles together
  AssetFolder plants;                ///< the folder that they must be in
  std::uint64_t (*clock_ns)() = now_ns;
};

/// Numbers of tiles by state, and sums since the scene was opened.
struct SceneStats {
  std::uint64_t instance_count = 0;  ///< in the file
  std::uint32_t tile_count = 0;
  std::uint32_t resident_tiles = 0;
  std::uint32_t wanted_tiles = 0;   ///< in demand by a view, resident or not
  std::uint32_t missing_tiles = 0;  ///< in demand, not resident, not failed
  float threshold_px = 0.0f;
  std::uint64_t tiles_loaded = 0;
  std::uint64_t tiles_dropped = 0;
  std::uint64_t tiles_failed = 0;
  std::uint32_t species_failed = 0;  ///< among those that a tile has needed
};

/// Adds the counts; keeps the larger threshold.
void add_stats(SceneStats& sum, const SceneStats& other);

/// A tile to place.
struct ReadyTile {
  std::uint32_t tile = 0;
  float size_px = 0.0f;                      ///< tile_size_px
  std::span<const SceneInstance> instances;  ///< until placed() or refused()
};

/// A plant to open.
struct WantedSpecies {
  std::uint32_t species = 0;
  const char* path = nullptr;  ///< joined to the scene's folder
};

/// Progress of a species.
enum class SpeciesState : std::uint8_t { unknown, wanted, opening, open, failed };

/// Thread: externally serialised; const functions may overlap with each other. The hooks and the ledger must outlive it.
class SceneStream {
 public:
  /// Opens the file, reads header and front through the I/O hook (which blocks) and checks them. A failed read is retried as ReadRetry
  /// says. errors  io, bad_file (one log line names file, field and byte), out_of_memory
  static Result<std::unique_ptr<SceneStream>> open(const Hooks& hooks, Ledger& ledger, const char* path, const SceneStreamOptions& options);
  /// Waits for running reads and jobs, closes the file.
  ~SceneStream();
  SceneStream(const SceneStream&) = delete;
  SceneStream& operator=(const SceneStream&) = delete;

  [[nodiscard]] const SceneFile& file() const;

  /// eyes         may be none: then no tile is in demand
  /// block_count  blocks of kTileBlockInstances slots that tiles may have, including their present ones
  void begin_frame(std::span<const SceneEye> eyes, std::uint32_t block_count);

  /// Tiles that were placed and are no longer resident since the last begin_frame.
  [[nodiscard]] std::span<const std::uint32_t> dropped() const;

  /// Returns the largest tile that is decoded and whose species are open or failed; none if there is nothing to place now.
  [[nodiscard]] std::optional<ReadyTile> next_ready();
  void placed(std::uint32_t tile);
  /// Memory was short; the tile is offered again.
  void refused(std::uint32_t tile);

  /// Returns a plant to open. One outside the allowed folder fails instead, with a line in the log.
  [[nodiscard]] std::optional<WantedSpecies> next_species();
  /// It is being opened: next_species() skips it until species_opened().
  void species_opening(std::uint32_t species);
  /// success: if false the species is never opened, and its instances are left out
  void species_opened(std::uint32_t species, bool success);
  [[nodiscard]] SpeciesState species_state(std::uint32_t species) const;
  /// The path joined to the scene's folder.
  [[nodiscard]] const char* species_path(std::uint32_t species) const;

  /// Lets tiles that have failed be requested again. Unreadable ones are read again after some seconds by themselves.
  void retry_failed();

  [[nodiscard]] SceneStats stats() const;

 private:
  struct State;
  explicit SceneStream(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace coppice
