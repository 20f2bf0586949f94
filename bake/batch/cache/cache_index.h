#pragma once

// How a cache lies on a server, and the one object there that says which keys exist. That is a hint, no more: writers may overwrite each
// other's, so that an entry may lack in it, and one that it names may be gone.

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "key_parts.h"
#include "result.h"

namespace coppice::bake {

/// Below a cache's address: "v1/ab/abcdef...". Another form of entries gets another number.
std::string entry_url(const std::string& cache_url, const std::string& key);
std::string index_url(const std::string& cache_url);
/// Of the record of the entry that was sent last of all plants with a file name: what explanations compare with.
/// name  32 hexadecimal digits: name_digits()
std::string record_url(const std::string& cache_url, const std::string& name);

/// The XXH3-128 of the parts' file name in hexadecimal digits.
std::string name_digits(std::span<const KeyPart> parts);

/// Of what has the folders of entries, "ab", and of what has those of records. With the slash that a listing is asked for by.
std::string folders_url(const std::string& cache_url);
std::string records_url(const std::string& cache_url);

/// Bytes of each entry by its key.
using CacheIndex = std::map<std::string, std::uint64_t>;

/// A line "coppice-cache-index 1", lines "KEY BYTES", a line "checksum ..." of all before.
std::string index_text(const CacheIndex& index);

/// errors  bad_file: it is no index, or a damaged one
Result<CacheIndex> read_index(std::string_view text);

/// Of a folder of a server.
struct ListedFile {
  std::string name;
  bool is_folder = false;
  std::uint64_t bytes = 0;
  std::int64_t modified_s = 0;  ///< since 1970, UTC; 0 where it is not said
};

/// A listing as nginx makes it with autoindex_format json.
/// errors  bad_file: it is no such listing
Result<std::vector<ListedFile>> read_listing(std::string_view text);

}  // namespace coppice::bake
