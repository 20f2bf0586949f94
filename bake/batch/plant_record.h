#pragma once

// What became of a plant, as JSON: an entry of `bake-all --report`, and a line of `--journal`.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "bake_batch.h"
#include "result.h"

namespace coppice::bake {

/// Of the foliage in the file, for each leaf of the plant that was modelled; 0 without any.
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
  Journal(Journal&& other) noexcept;
  Journal& operator=(Journal&&) = delete;
  ~Journal();
  /// errors  io
  Result<void> add(const BatchPlant& plant, const BatchResult& result);

 private:
  Journal(std::filesystem::path path, int file);
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace coppice::bake
