#include "plant_pictures.h"

#include <algorithm>
#include <new>
#include <utility>

#include "atomic_file.h"
#include "baked_picture.h"
#include "job_processes.h"

namespace coppice::bake {

namespace fs = std::filesystem;

static fs::path picture_path(const fs::path& folder, const std::string& key) {
  return folder / (key + ".webp");
}

/// Whether read_picture finds one, without reading it.
static bool has_picture(const fs::path& folder, const std::string& key) {
  return static_cast<bool>(read_kept_file(picture_path(folder, key), FileOwner::user, 0));
}

fs::path picture_folder(const fs::path& output_folder) {
  return output_folder / ".coppice-pictures";
}

Result<std::vector<std::uint8_t>> read_picture(const fs::path& folder, const std::string& key) {
  return read_kept_file(picture_path(folder, key), FileOwner::user);
}

Result<void> draw_picture(const fs::path& output, const std::string& key, const fs::path& folder) try {
  const fs::path path = picture_path(folder, key);
  if (has_picture(folder, key)) return {};
  COPPICE_TRY(bytes, read_file(output));
  COPPICE_TRY(picture, baked_picture(bytes));
  COPPICE_CHECK(make_folder_of(path));
  return write_file_atomically(path, picture, LastLink::stays);
} catch (const std::bad_alloc&) {
  return Error{Status::out_of_memory, "out of memory"};
}

std::vector<std::string> draw_missing_pictures(const std::vector<BatchPlant>& plants, const std::vector<BatchResult>& results,
                                               const fs::path& folder, std::size_t at_a_time) {
  std::vector<std::string> failures(plants.size());
  std::vector<std::size_t> jobs;
  for (std::size_t i = 0; i < plants.size(); ++i)
    if (results[i].outcome != BatchOutcome::failed && !has_picture(folder, results[i].key)) jobs.push_back(i);
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t job, const JobProgress&) {
    const std::size_t plant = jobs[job];
    const auto drawn = draw_picture(plants[plant].output, results[plant].key, folder);
    return drawn ? std::string() : drawn.error().message();
  };
  callbacks.ended = [&](std::size_t job, JobEnd end) {
    failures[jobs[job]] = end.failure.empty() ? std::move(end.result) : std::move(end.failure);
  };
  if (!jobs.empty()) run_jobs(jobs.size(), std::max<std::size_t>(1, at_a_time), callbacks);
  return failures;
}

}  // namespace coppice::bake
