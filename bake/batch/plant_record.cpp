#include "plant_record.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "atomic_file.h"
#include "text_bytes.h"

namespace coppice::bake {

/// Where a network file system gives all files to a user of its own, ours are those that belong to whom a new one belongs to.
static bool is_ours(const struct stat& file, FilePlace place) {
  if (file.st_uid == ::geteuid()) return true;
  const auto beside = TemporaryFile::create_beside(std::move(place));
  const auto owner = beside ? beside->owner() : beside.error();
  return owner && *owner == file.st_uid;
}

double bytes_per_leaf(const BatchResult& result) {
  return result.source_leaves > 0 ? static_cast<double>(result.foliage_bytes) / result.source_leaves : 0.0;
}

nlohmann::ordered_json plant_record(const BatchPlant& plant, const BatchResult& result) {
  nlohmann::ordered_json json = {{"input", plant.input.string()}, {"output", plant.output.string()}, {"outcome", result.outcome}};
  if (result.outcome == BatchOutcome::failed)
    json.update({{"error", result.error}, {"lost", result.lost}});
  else
    json.update({{"source_leaves", result.source_leaves},
                 {"file_bytes", result.file_bytes},
                 {"foliage_bytes", result.foliage_bytes},
                 {"bytes_per_leaf", bytes_per_leaf(result)}});
  json.update({{"key", result.key},
               {"seconds", result.seconds},
               {"peak_rss_bytes", result.peak_rss_bytes},
               {"warnings", result.warnings},
               {"because", result.because}});
  return json;
}

std::string journal_line(const BatchPlant& plant, const BatchResult& result) {
  return json_line(plant_record(plant, result)) + "\n";
}

std::optional<JournalEntry> journal_entry(std::string_view line) try {
  const auto json = nlohmann::json::parse(line);
  return JournalEntry{json.at("output").get<std::string>(), json.get<BatchResult>()};
} catch (const nlohmann::json::exception&) {
  return {};
}

Result<Journal> Journal::open(const std::filesystem::path& path) {
  COPPICE_TRY(place, find_place(path));
  constexpr int kFlags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK;
  Descriptor file(::openat(place.folder.number(), place.name.c_str(), kFlags, 0666));
  struct stat status {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0) return system_error("cannot write", path, errno);
  if (!S_ISREG(status.st_mode) && !is_null_device(place)) return not_written(path);
  // What is added to a file of another name, or of another user, does harm there.
  if (S_ISREG(status.st_mode) && (status.st_nlink != 1 || !is_ours(status, std::move(place))))
    return Error{Status::io, "cannot add to a file of another user, or of several names", Error::kNoOffset,
                 path.string() + ": name another file, or remove this one"};
  return Journal(path, std::move(file));
}

Result<void> Journal::add(const BatchPlant& plant, const BatchResult& result) {
  COPPICE_CHECK(write_all(file_.number(), bytes_of(journal_line(plant, result)), path_));
  // Others read it while it grows, through a file system that may keep it back. Some cannot sync; then they see it when it is closed.
  static_cast<void>(::fdatasync(file_.number()));
  return {};
}

}  // namespace coppice::bake
