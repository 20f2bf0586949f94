#pragma once

// What tasks have told, by files in RUN/tries/.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "plant_record.h"
#include "remote_cache.h"

namespace coppice::bake {

/// One run of a task's script.
struct TaskTry {
  std::uint32_t submission = 0, task = 0;
  std::string node, job, array_job;
  double started_s = 0.0;        ///< seconds since 1970, by the node's clock
  double ended_s = 0.0;          ///< likewise; 0 where it has not told
  std::optional<int> exit_code;  ///< of bake-all; nothing: it has not ended, or was ended from outside
  bool is_read = false;          ///< its journal will not grow, and has been read
  std::uint64_t read_bytes = 0;  ///< of its journal
  std::filesystem::path log;     ///< what it printed
};

struct TriedPlant {
  std::string try_name;
  JournalEntry entry;
};

/// Tries by their names.
using Tries = std::map<std::string, TaskTry>;

/// Looks what has come since the last call: adds tries that have started, and ends. returns  plants that have ended since, in the order of
/// tries and of their journals. What is only half there is read the next time.
std::vector<TriedPlant> read_tries(const std::filesystem::path& run_folder, Tries& tries);

/// Adds what another cache, or the same elsewhere, did: sums, and the first place and trouble.
void add_cache_report(CacheReport& sum, const CacheReport& of);

/// What a cache did for tasks, by the reports of those that ended. where  as of CacheReport: tasks may have had another
CacheReport read_task_caches(const std::filesystem::path& run_folder, const std::string& where);

/// Makes a network file system ask again what is in the folder: by a file of our own that comes and goes.
void refresh_tries(const std::filesystem::path& run_folder);

/// The last lines of a file, at most 4096 bytes of it; empty where there is none.
std::string tail_of(const std::filesystem::path& file);

}  // namespace coppice::bake
