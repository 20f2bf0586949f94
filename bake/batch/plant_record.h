#pragma once

// What became of a plant, as JSON: an entry of `bake-all --report`, and a line of `--journal`.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "bake_batch.h"
#include "result.h"
#include "temporary_file.h"

namespace coppice::bake {

// A result on its way from the process that made it, and what a line of a journal has of it.
NLOHMANN_JSON_SERIALIZE_ENUM(BatchOutcome,
                             {{BatchOutcome::failed, "failed"}, {BatchOutcome::baked, "baked"}, {BatchOutcome::cached, "cached"}})
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE_WITH_DEFAULT(BatchResult, outcome, error, key, source_leaves, file_bytes, foliage_bytes, seconds,
                                                peak_rss_bytes, warnings, folder_failure, server_failure, sent, lost_s, because, lost)

/// The foliage's bytes in the file for each leaf that was modelled; 0 without any.
double bytes_per_leaf(const BatchResult& result);

/// bake/README.md has the keys.
nlohmann::ordered_json plant_record(const BatchPlant& plant, const BatchResult& result);

struct JournalEntry {
  std::string output;
  BatchResult result;
};

/// A line of a journal, with its end.
std::string journal_line(const BatchPlant& plant, const BatchResult& result);

/// What a line of a journal says; nothing where it is no whole one.
std::optional<JournalEntry> journal_entry(std::string_view line);

/// A file that gets a line for each plant that has ended, on disk before the next one ends. What a killed process leaves is whole up to
/// its last line.
class Journal {
 public:
  /// Adds to what is there. errors  io
  static Result<Journal> open(const std::filesystem::path& path);
  /// errors  io
  Result<void> add(const BatchPlant& plant, const BatchResult& result);

 private:
  Journal(std::filesystem::path path, Descriptor file) : path_(std::move(path)), file_(std::move(file)) {}
  std::filesystem::path path_;
  Descriptor file_;
};

}  // namespace coppice::bake
