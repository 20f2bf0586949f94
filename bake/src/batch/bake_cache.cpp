#include "bake_cache.h"

#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "checksum.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

std::filesystem::path record_path(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".record");
}

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string checksum_of(const CachedBake& entry, const Json& record) {
  Checksum checksum;
  checksum.add(entry.bytes);
  checksum.add(text_of(record));
  return checksum.text();
}

Json record_of(const CachedBake& entry) {
  return {{"source_leaves", entry.source_leaves}, {"foliage_bytes", entry.foliage_bytes}, {"warnings", entry.warnings}};
}

/// Whether the text is the record of these bytes; fills in what it says of them.
bool read_record(std::span<const std::uint8_t> text, CachedBake& entry) {
  Json record = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!record.is_object() || !record.contains("checksum") || !record["checksum"].is_string()) return false;
  const std::string expected = record["checksum"];
  record.erase("checksum");
  // Its form first: writing it out for the checksum recurses, which a record of ours does not.
  for (const char* key : {"source_leaves", "foliage_bytes", "warnings"})
    if (!record.contains(key) || record.size() != 3) return false;
  const Json &leaves = record["source_leaves"], &bytes = record["foliage_bytes"], &warnings = record["warnings"];
  if (!leaves.is_number_unsigned() || leaves.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) return false;
  if (!bytes.is_number_unsigned() || !warnings.is_array()) return false;
  if (!std::ranges::all_of(warnings, [](const Json& warning) { return warning.is_string(); })) return false;
  if (checksum_of(entry, record) != expected) return false;
  entry.source_leaves = leaves.get<std::uint32_t>();
  entry.foliage_bytes = bytes.get<std::uint64_t>();
  entry.warnings = warnings.get<std::vector<std::string>>();
  return true;
}

}  // namespace

std::filesystem::path cached_file(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".coppice");
}

Result<CachedBake> load_cached(const std::filesystem::path& folder, const std::string& key) {
  COPPICE_TRY(record, read_file(record_path(folder, key)));
  CachedBake entry;
  COPPICE_TRY(bytes, read_file(cached_file(folder, key)));
  entry.bytes = std::move(bytes);
  if (read_record(record, entry)) return entry;
  // Not an entry any more: a bake that then fails must not leave it for the next to stumble over.
  std::error_code ignored;
  std::filesystem::remove(record_path(folder, key), ignored);
  return Error{Status::bad_file, "a file of the cache is damaged", Error::kNoOffset, cached_file(folder, key).string()};
}

Result<void> store_cached(const std::filesystem::path& folder, const std::string& key, const CachedBake& entry) {
  COPPICE_CHECK(write_file_atomically(cached_file(folder, key), entry.bytes));
  Json record = record_of(entry);
  record["checksum"] = checksum_of(entry, record_of(entry));
  const std::string text = text_of(record);
  return write_file_atomically(record_path(folder, key), {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace coppice::bake
