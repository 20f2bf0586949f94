#include "cache_listing.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include "cache_index.h"
#include "key_parts.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

/// Of one folder; nothing where there is no such folder.
Result<std::vector<ListedFile>> list_folder(const HttpAsk& ask, const std::string& url) {
  constexpr int kForbidden = 403;
  const HttpAnswer answer = ask({.method = HttpMethod::get, .url = url});
  if (answer.trouble != HttpTrouble::none) return Error{Status::io, "the cache cannot be listed", Error::kNoOffset, answer.why};
  if (is_absent(answer.status)) return std::vector<ListedFile>();
  if (answer.status == kForbidden)
    return Error{Status::unsupported,
                 "the server lists no folders, or does not let you; nginx does with: autoindex on; autoindex_format json;"};
  if (answer.status != 200) return Error{Status::io, "the cache cannot be listed", Error::kNoOffset, status_text(answer.status)};
  auto files = read_listing(as_text(answer.body));
  if (!files) return Error{Status::unsupported, files.error().what};
  return files;
}

/// Files with names like keys, each in a folder of its first two digits, in order of their names.
Result<std::vector<ListedEntry>> list_keys(const HttpAsk& ask, const std::string& folders) {
  COPPICE_TRY(listed, list_folder(ask, folders));
  std::vector<ListedEntry> entries;
  for (const ListedFile& folder : listed) {
    if (!folder.is_folder || folder.name.size() != 2) continue;
    COPPICE_TRY(files, list_folder(ask, folders + folder.name + "/"));
    for (const ListedFile& file : files)
      if (!file.is_folder && is_key(file.name) && file.name.starts_with(folder.name))
        entries.push_back({file.name, file.bytes, file.modified_s});
  }
  std::ranges::sort(entries, {}, &ListedEntry::key);
  return entries;
}

}  // namespace

Result<std::vector<ListedEntry>> list_cache(const HttpAsk& ask, const std::string& cache_url) {
  return list_keys(ask, folders_url(cache_url));
}

Result<std::vector<std::string>> list_records(const HttpAsk& ask, const std::string& cache_url) {
  COPPICE_TRY(files, list_keys(ask, records_url(cache_url)));
  std::vector<std::string> names;
  for (ListedEntry& file : files) names.push_back(std::move(file.key));
  return names;
}

}  // namespace coppice::bake
