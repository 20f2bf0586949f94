#include "cache_index.h"

#include <ctime>

#include <nlohmann/json.hpp>

#include "checksum.h"
#include "key_parts.h"
#include "text_number.h"

namespace coppice::bake {
namespace {

constexpr std::string_view kFirstLine = "coppice-cache-index 1\n", kLastLine = "checksum ";

std::string checksum_line(std::string_view text) {
  Checksum checksum;
  checksum.add(text);
  return std::string(kLastLine) + checksum.text() + "\n";
}

/// "KEY BYTES" into the index.
bool read_line(std::string_view line, CacheIndex& index) {
  const std::string_view key = line.substr(0, line.find(' '));
  if (!is_key(key) || key.size() == line.size()) return false;
  const auto bytes = number_of<std::uint64_t>(line.substr(key.size() + 1));
  if (bytes) index.emplace(key, *bytes);
  return bytes.has_value();
}

/// "Thu, 26 Nov 2026 22:07:53 GMT"
std::int64_t seconds_of_date(const std::string& text) {
  std::tm date{};
  const char* const end = ::strptime(text.c_str(), "%a, %d %b %Y %H:%M:%S GMT", &date);
  return end == nullptr ? 0 : static_cast<std::int64_t>(::timegm(&date));
}

}  // namespace

std::string folders_url(const std::string& cache_url) {
  return cache_url + "/v1/";
}

std::string records_url(const std::string& cache_url) {
  return folders_url(cache_url) + "records/";
}

std::string entry_url(const std::string& cache_url, const std::string& key) {
  return folders_url(cache_url) + key.substr(0, 2) + "/" + key;
}

std::string index_url(const std::string& cache_url) {
  return folders_url(cache_url) + "index";
}

std::string record_url(const std::string& cache_url, const std::string& name) {
  return records_url(cache_url) + name.substr(0, 2) + "/" + name;
}

std::string name_digits(std::span<const KeyPart> parts) {
  Checksum checksum;
  for (const KeyPart& part : parts)
    if (part.kind == "name") checksum.add(part.value);
  return checksum.text();
}

std::string index_text(const CacheIndex& index) {
  std::string text(kFirstLine);
  for (const auto& [key, bytes] : index) text.append(key).append(" ").append(std::to_string(bytes)).append("\n");
  return text + checksum_line(text);
}

Result<CacheIndex> read_index(std::string_view text) {
  const Error damaged{Status::bad_file, "the cache's index is damaged"};
  const std::size_t last = text.rfind(kLastLine);
  if (!text.starts_with(kFirstLine) || last == std::string_view::npos) return damaged;
  if (text.substr(last) != checksum_line(text.substr(0, last))) return damaged;
  CacheIndex index;
  std::string_view lines = text.substr(kFirstLine.size(), last - kFirstLine.size());
  while (!lines.empty()) {
    const std::string_view line = lines.substr(0, lines.find('\n'));
    if (line.size() == lines.size() || !read_line(line, index)) return damaged;
    lines.remove_prefix(line.size() + 1);
  }
  return index;
}

Result<std::vector<ListedFile>> read_listing(std::string_view text) {
  const Error bad{Status::bad_file, "the server gives no listing in JSON; nginx does with: autoindex on; autoindex_format json;"};
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_array()) return bad;
  std::vector<ListedFile> files;
  for (const nlohmann::json& entry : json) {
    if (!entry.is_object() || !entry.contains("name") || !entry["name"].is_string()) return bad;
    ListedFile file{entry["name"].get<std::string>()};
    const auto text_of = [&entry](const char* key) {
      return entry.contains(key) && entry[key].is_string() ? entry[key].get<std::string>() : std::string();
    };
    file.is_folder = text_of("type") == "directory";
    file.modified_s = seconds_of_date(text_of("mtime"));
    if (entry.contains("size") && entry["size"].is_number_unsigned()) file.bytes = entry["size"].get<std::uint64_t>();
    files.push_back(std::move(file));
  }
  return files;
}

}  // namespace coppice::bake
