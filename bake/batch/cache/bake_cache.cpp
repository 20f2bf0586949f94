#include "bake_cache.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <limits>

#include <nlohmann/json.hpp>

#include "text_bytes.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

std::string entry_checksum(std::span<const std::uint8_t> bytes, const Json& record) {
  const std::string text = json_file(record);
  return checksum_of(std::array{as_text(bytes), std::string_view(text)});
}

Json record_of(const CachedBake& entry) {
  Json parts = Json::array();
  for (const KeyPart& part : entry.parts) parts.push_back({part.kind, part.name, part.value});
  return {{"source_leaves", entry.source_leaves},
          {"foliage_bytes", entry.foliage_bytes},
          {"warnings", entry.warnings},
          {"parts", std::move(parts)}};
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

/// Nothing where the text is no JSON. What is nested deeper than a part's text is left out: a bracket in brackets takes 64 bytes.
Json parsed_record(std::span<const std::uint8_t> text) {
  const auto is_kept = [](int depth, Json::parse_event_t, Json&) { return depth < 4; };
  return text.size() > kMaxRecordBytes ? Json(Json::value_t::discarded) : Json::parse(text.begin(), text.end(), is_kept, false);
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
  if (key_of(entry.parts) != key || entry_checksum(bytes, record) != expected) return false;
  entry.source_leaves = leaves.get<std::uint32_t>();
  entry.foliage_bytes = foliage.get<std::uint64_t>();
  entry.warnings = record["warnings"].get<std::vector<std::string>>();
  return true;
}

/// The folder is opened once for all that is done to an entry.
Result<FilePlace> record_place(const std::filesystem::path& folder, const std::string& key) {
  return find_place(record_file(folder, key), LastLink::stays);
}

Result<CachedBake> read_at(const FilePlace& record, const std::string& key, std::uint64_t max_bytes) {
  COPPICE_TRY(file, beside(record, cached_file({}, key)));
  COPPICE_TRY(text, read_kept_file(record, FileOwner::anybody, kMaxRecordBytes + 1));
  struct stat status {};
  if (::fstatat(file.folder.number(), file.name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode) &&
      static_cast<std::uint64_t>(status.st_size) > max_bytes)
    return Error{Status::unsupported, "an entry of the cache is larger than what is read", Error::kNoOffset,
                 file.path.string() + ": " + std::to_string(status.st_size) + " bytes, at most " + std::to_string(max_bytes)};
  COPPICE_TRY(bytes, read_kept_file(file, FileOwner::anybody, max_bytes));
  Result<CachedBake> entry = read_entry(text, std::move(bytes), key);
  if (entry) return entry;
  return Error{Status::bad_file, "a file of the cache is damaged", Error::kNoOffset, file.path.string()};
}

}  // namespace

std::filesystem::path cached_file(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".coppice");
}

std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".record");
}

Result<CachedBake> peek_cached(const std::filesystem::path& folder, const std::string& key, std::uint64_t max_bytes) {
  COPPICE_TRY(record, record_place(folder, key));
  return read_at(record, key, max_bytes);
}

Result<CachedBake> load_cached(const std::filesystem::path& folder, const std::string& key, DamagedEntry damaged, std::uint64_t max_bytes) {
  COPPICE_TRY(record, record_place(folder, key));
  Result<CachedBake> entry = read_at(record, key, max_bytes);
  // Not an entry any more: a bake that then fails must not leave it for the next to stumble over.
  const bool is_damaged = !entry && entry.error().status == Status::bad_file;
  if (is_damaged && damaged == DamagedEntry::is_removed) ::unlinkat(record.folder.number(), record.name.c_str(), 0);
  // What prune goes by. Whoever may not write there uses it all the same.
  if (entry) static_cast<void>(::utimensat(record.folder.number(), record.name.c_str(), nullptr, AT_SYMLINK_NOFOLLOW));
  return entry;
}

Result<void> store_cached(const std::filesystem::path& folder, const std::string& key, const CachedBake& entry) {
  COPPICE_TRY(record, record_place(folder, key));
  COPPICE_TRY(file, beside(record, cached_file({}, key)));
  COPPICE_CHECK(write_file_atomically(file, entry.bytes));
  Result<void> recorded = write_file_atomically(record, bytes_of(record_text(entry)));
  struct stat status {};
  // Where there is no room for the record, the file is in the way of others.
  if (!recorded && ::fstatat(record.folder.number(), record.name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0)
    ::unlinkat(file.folder.number(), file.name.c_str(), 0);
  return recorded;
}

std::vector<KeyPart> parts_of_record(std::span<const std::uint8_t> record) {
  const Json json = parsed_record(record);
  return json.is_object() && json.contains("parts") && are_parts(json["parts"]) ? parts_of(json["parts"]) : std::vector<KeyPart>();
}

std::string record_text(const CachedBake& entry) {
  Json record = record_of(entry);
  record["checksum"] = entry_checksum(entry.bytes, record_of(entry));
  return json_file(record);
}

Result<CachedBake> read_entry(std::span<const std::uint8_t> record, std::vector<std::uint8_t> bytes, const std::string& key) {
  CachedBake entry;
  entry.bytes = std::move(bytes);
  if (read_record(record, entry.bytes, key, entry)) return entry;
  return Error{Status::bad_file, "an entry of the cache is damaged", Error::kNoOffset, key};
}

}  // namespace coppice::bake
