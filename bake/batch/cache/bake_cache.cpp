#include "bake_cache.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "checksum.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kBundleStart = "coppice-cache 1 ";

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string checksum_of(std::span<const std::uint8_t> bytes, const Json& record) {
  Checksum checksum;
  checksum.add(bytes);
  checksum.add(text_of(record));
  return checksum.text();
}

Json record_of(const CachedBake& entry) {
  Json parts = Json::array();
  for (const KeyPart& part : entry.parts) parts.push_back({part.kind, part.name, part.value});
  return {{"source_leaves", entry.source_leaves},
          {"foliage_bytes", entry.foliage_bytes},
          {"warnings", entry.warnings},
          {"parts", std::move(parts)}};
}

std::string record_text(const CachedBake& entry) {
  Json record = record_of(entry);
  record["checksum"] = checksum_of(entry.bytes, record_of(entry));
  return text_of(record);
}

bool are_strings(const Json& array) {
  return array.is_array() && std::ranges::all_of(array, [](const Json& text) { return text.is_string(); });
}

bool are_parts(const Json& parts) {
  return parts.is_array() && std::ranges::all_of(parts, [](const Json& part) { return are_strings(part) && part.size() == 3; });
}

std::vector<KeyPart> parts_of(const Json& parts) {
  std::vector<KeyPart> all;
  for (const Json& part : parts) all.push_back({part[0].get<std::string>(), part[1].get<std::string>(), part[2].get<std::string>()});
  return all;
}

/// Nothing where the text is no object of JSON.
Json parsed_record(std::span<const std::uint8_t> text) {
  return text.size() > kMostRecordBytes ? Json(Json::value_t::discarded) : Json::parse(text.begin(), text.end(), nullptr, false);
}

/// Whether the text is the record of these bytes under that key; fills in what it says of them.
bool read_record(std::span<const std::uint8_t> text, std::span<const std::uint8_t> bytes, const std::string& key, CachedBake& entry) {
  Json record = parsed_record(text);
  if (!record.is_object() || !record.contains("checksum") || !record["checksum"].is_string()) return false;
  const std::string expected = record["checksum"];
  record.erase("checksum");
  // Its form first: writing it out for the checksum recurses, which a record of ours does not.
  for (const char* name : {"source_leaves", "foliage_bytes", "warnings", "parts"})
    if (!record.contains(name) || record.size() != 4) return false;
  const Json &leaves = record["source_leaves"], &foliage = record["foliage_bytes"];
  if (!leaves.is_number_unsigned() || leaves.get<std::uint64_t>() > std::numeric_limits<std::uint32_t>::max()) return false;
  if (!foliage.is_number_unsigned() || !are_strings(record["warnings"]) || !are_parts(record["parts"])) return false;
  entry.parts = parts_of(record["parts"]);
  if (key_of(entry.parts) != key || checksum_of(bytes, record) != expected) return false;
  entry.source_leaves = leaves.get<std::uint32_t>();
  entry.foliage_bytes = foliage.get<std::uint64_t>();
  entry.warnings = record["warnings"].get<std::vector<std::string>>();
  return true;
}

}  // namespace

std::filesystem::path cached_file(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".coppice");
}

std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".record");
}

Result<CachedBake> peek_cached(const std::filesystem::path& folder, const std::string& key) {
  COPPICE_TRY(record, read_file(record_file(folder, key), kMostRecordBytes + 1));
  CachedBake entry;
  COPPICE_TRY(bytes, read_file(cached_file(folder, key)));
  entry.bytes = std::move(bytes);
  if (read_record(record, entry.bytes, key, entry)) return entry;
  return Error{Status::bad_file, "a file of the cache is damaged", Error::kNoOffset, cached_file(folder, key).string()};
}

Result<CachedBake> load_cached(const std::filesystem::path& folder, const std::string& key, DamagedEntry damaged) {
  Result<CachedBake> entry = peek_cached(folder, key);
  const std::filesystem::path record = record_file(folder, key);
  std::error_code ignored;
  // Not an entry any more: a bake that then fails must not leave it for the next to stumble over.
  const bool is_damaged = !entry && entry.error().status == Status::bad_file;
  if (is_damaged && damaged == DamagedEntry::is_removed) std::filesystem::remove(record, ignored);
  // What prune goes by. Whoever may not write there uses it all the same.
  if (entry) static_cast<void>(::utimensat(AT_FDCWD, record.c_str(), nullptr, 0));
  return entry;
}

Result<void> store_cached(const std::filesystem::path& folder, const std::string& key, const CachedBake& entry) {
  COPPICE_CHECK(write_file_atomically(cached_file(folder, key), entry.bytes));
  Result<void> recorded = write_file_atomically(record_file(folder, key), bytes_of(record_text(entry)));
  std::error_code ignored;
  // Where there is no room for the record, the file is in the way of others.
  if (!recorded && !std::filesystem::exists(record_file(folder, key), ignored)) std::filesystem::remove(cached_file(folder, key), ignored);
  return recorded;
}

std::vector<KeyPart> parts_of_record(std::span<const std::uint8_t> record) {
  const Json json = parsed_record(record);
  return json.is_object() && json.contains("parts") && are_parts(json["parts"]) ? parts_of(json["parts"]) : std::vector<KeyPart>();
}

std::vector<std::uint8_t> bundle_of(const CachedBake& entry) {
  const std::string record = record_text(entry), head = std::string(kBundleStart) + std::to_string(record.size()) + "\n";
  std::vector<std::uint8_t> bundle;
  bundle.reserve(head.size() + record.size() + entry.bytes.size());
  bundle.insert(bundle.end(), head.begin(), head.end());
  bundle.insert(bundle.end(), record.begin(), record.end());
  bundle.insert(bundle.end(), entry.bytes.begin(), entry.bytes.end());
  return bundle;
}

Result<CachedBake> read_bundle(std::span<const std::uint8_t> bundle, const std::string& key) {
  const Error damaged{Status::bad_file, "an entry of the cache is damaged", Error::kNoOffset, key};
  const std::string_view text = as_text(bundle);
  if (!text.starts_with(kBundleStart)) return damaged;
  std::size_t record_bytes = 0;
  const auto [end, error] = std::from_chars(text.data() + kBundleStart.size(), text.data() + text.size(), record_bytes);
  if (error != std::errc() || end == text.data() + text.size() || *end != '\n') return damaged;
  const auto head_bytes = static_cast<std::size_t>(end - text.data()) + 1;
  if (record_bytes > bundle.size() - head_bytes) return damaged;
  CachedBake entry;
  const auto file = bundle.subspan(head_bytes + record_bytes);
  if (!read_record(bundle.subspan(head_bytes, record_bytes), file, key, entry)) return damaged;
  entry.bytes.assign(file.begin(), file.end());
  return entry;
}

}  // namespace coppice::bake
