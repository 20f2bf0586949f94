#pragma once

// Many plants in one go: what `coppice bake-all` does. Each is baked in a process of its own and kept under its key (bake_cache.h), so that
// a plant that has not changed, or has changed back, is not baked again, and a batch that was killed goes on where it was.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bake.h"
#include "cache_location.h"
#include "job_processes.h"
#include "plant_cost.h"
#include "result.h"

namespace coppice::bake {

struct BatchPlant {
  std::filesystem::path input;
  std::filesystem::path output;  ///< folders that are missing are made; empty: for bake_cached, in the cache alone
  BakeOptions options;
  bool all_variants = false;                      ///< a plant for each of the input's variants: expand_variants
  std::string place = {};                         ///< its entry of a list, "[2]", for errors; empty: in none
  std::string failure = {};                       ///< why its variants are not known: it is not baked, and fails with that
  PlantCost cost = {};                            ///< estimate_inputs; 0: not known
  std::vector<std::filesystem::path> files = {};  ///< that the input refers to, unless it is the one before: estimate_inputs
};

/// Every .glb and .gltf below a folder, whatever the case of its extension, sorted by path. The output is as far below `output_folder`,
/// with the extension .coppice. Links to folders are not followed.
/// errors  io: the folder cannot be read; invalid_argument: there is none in it
Result<std::vector<BatchPlant>> plants_of_folder(const std::filesystem::path& folder, const std::filesystem::path& output_folder,
                                                 const BakeOptions& options);

/// Whether the name ends as a glTF file's does, .glb or .gltf, whatever the case.
bool is_plant_file(const std::filesystem::path& path);

/// Plants with all_variants become one for each variant, with the outputs of variant_outputs. Each input is looked at in a process of its
/// own, under `limits`; one that cannot be read stays as it is, and fails when it is baked, also where only the look at it ran out of
/// memory or time. thread  the process must have no other threads (job_processes.h)
std::vector<BatchPlant> expand_variants(const std::vector<BatchPlant>& plants, const JobLimits& limits);

/// Sets their costs and files, by what their JSON says.
void estimate_inputs(std::vector<BatchPlant>& plants);
std::vector<PlantCost> costs_of(const std::vector<BatchPlant>& plants);

/// Refuses two plants with one output, and an output that is an input of any or a file of one, or that coppice keeps for itself: a file
/// ".coppice-...", or one below ".coppice-cache", ".coppice-cluster" or ".coppice-pictures". Paths count as they are with links followed.
/// other_inputs  the list of the plants
/// errors        invalid_argument: names the plant, or both
Result<void> check_batch(const std::vector<BatchPlant>& plants, const std::vector<std::filesystem::path>& other_inputs = {});

enum class BatchOutcome { baked, cached, failed };

/// "baked", "cached", "failed"
const char* outcome_name(BatchOutcome outcome);

/// What became of one plant. What is not known of one that failed is 0 or empty.
struct BatchResult {
  BatchOutcome outcome = BatchOutcome::failed;
  std::string error;  ///< one line; empty unless it failed
  std::string key;    ///< bake_key
  std::uint32_t source_leaves = 0;
  std::uint64_t file_bytes = 0, foliage_bytes = 0;
  double seconds = 0.0;  ///< wall time of this run
  std::uint64_t peak_rss_bytes = 0;
  std::vector<std::string> warnings;  ///< the importer's, those of a cached plant from when it was baked; and of a damaged cache
  std::string folder_failure;         ///< why the cache's folder did not keep it; empty: it did, or need not
  std::string server_failure;         ///< why the cache's server was of no use to it; empty: it was, or was not asked
  bool sent = false;                  ///< the server took it
  double lost_s = 0.0;                ///< time for which the server gave nothing
  std::vector<std::string> because;   ///< with BatchOptions::explain: why it was baked, one line each
  bool lost = false;                  ///< it failed because something else ended its process: JobEnd::lost
};

/// Bakes one plant, unless the cache has it, and sees to it that the output is the result: written atomically, left alone if it is that
/// already. Does not throw for what is wrong with the plant.
/// cache  folder; made if it is missing
BatchResult bake_cached(const BatchPlant& plant, const std::filesystem::path& cache, const StageProgress& progress);

struct BatchStatus {
  std::size_t ended = 0, count = 0;  ///< plants
  double fraction = 0.0;             ///< the share that is done, from 0 to 1
  std::string running;               ///< names, for a person
};

/// A cache that others use too.
struct SharedCache {
  CacheLocation location;  ///< both empty: there is none
  CacheMode mode = CacheMode::read_write;
  CacheCredentials credentials = {};
};

/// What a batch's cache did: the shared one, where there is one.
struct CacheReport {
  std::string where;                     ///< folder or address; empty: there was none
  std::uint64_t found = 0, lacking = 0;  ///< plants that it had; that it had not, or not in time
  std::uint64_t sent = 0, unsent = 0;    ///< results that it took; that it did not take
  bool gave_up = false;                  ///< it was asked no more before the batch was done
  std::string trouble;                   ///< the first thing that was wrong with it; empty: nothing
};

struct BatchOptions {
  std::filesystem::path cache;  ///< folder; made if it is missing. Empty: no cache at all
  std::uint32_t job_count = 0;  ///< plants at a time; 0: default_job_count. What is written does not depend on it
  JobLimits limits;             ///< each plant has them for itself
  /// A folder takes the place of `cache`, unless it is only read. A folder that is only read, and a server, are asked for what `cache`
  /// lacks.
  SharedCache shared = {};
  bool other_batches = false;           ///< others that say so too may use `cache` at the same time; else that is refused
  bool explain = false;                 ///< fill BatchResult::because
  bool look_up_only = false;            ///< bake nothing: a plant that no cache has fails
  std::filesystem::path pictures = {};  ///< folder for a picture of each plant (plant_pictures.h); empty: none
  std::function<void(const BatchPlant& plant, const BatchResult& result)> ended = {};  ///< as each plant ends; may be empty
  std::function<void(const CacheReport&)> cache_reported = {};  ///< called once, at the end; empty: nobody wants to know
};

/// As many plants at a time as there are processors, or as half of the free memory holds by their costs; at least one.
std::uint32_t default_job_count(const std::vector<BatchPlant>& plants);

/// bake_cached for each, the slowest first by their costs. Results are in the order of the plants. A plant that fails, or whose process
/// crashes or is killed, keeps none of the others from being baked. Plants without a thread_count of their own share the processors.
/// A server is asked for all plants first, several at a time. A shared cache that is of no use (dead, slow, full, refusing, damaged) is
/// asked no more after a few failures in a row, or once it has taken 10 s and a tenth of the time of the bakes, and costs no plant.
/// plants  check_batch takes them
/// errors  io: `cache` cannot be made, or another process is using it
/// thread  the process must have no other threads (job_processes.h)
Result<std::vector<BatchResult>> bake_batch(const std::vector<BatchPlant>& plants, const BatchOptions& options,
                                            const std::function<void(const BatchStatus&)>& progress);

}  // namespace coppice::bake
