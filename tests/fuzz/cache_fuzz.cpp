// libFuzzer: any bytes as the record of a cached bake are refused, and then are no entry any more, or are read as an entry that is stored
// again unchanged. Byte 0 says whether the record's checksum is made right, which lets any JSON object past it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bake_cache.h"
#include "check.h"
#include "scratch_file.h"
#include "text_bytes.h"

namespace {

using Json = nlohmann::ordered_json;
using coppice::test::scratch_folder;

constexpr std::uint8_t kPlant[] = {'p', 'l', 'a', 'n', 't'};

/// As the cache counts it: the plant's bytes, then the record without the checksum.
std::string with_checksum(std::span<const std::uint8_t> text) {
  Json record = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!record.is_object()) return {text.begin(), text.end()};
  record.erase("checksum");
  const std::string counted = record.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  record["checksum"] = coppice::bake::checksum_of(std::array{coppice::bake::as_text(kPlant), std::string_view(counted)});
  return record.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void check_entry(const std::string& key, const coppice::bake::CachedBake& entry) {
  COPPICE_ASSERT(std::equal(entry.bytes.begin(), entry.bytes.end(), std::begin(kPlant), std::end(kPlant)));
  COPPICE_ASSERT(coppice::bake::store_cached(scratch_folder(), key, entry));
  const auto again = coppice::bake::load_cached(scratch_folder(), key);
  COPPICE_ASSERT(again && again->bytes == entry.bytes && again->source_leaves == entry.source_leaves);
  COPPICE_ASSERT(again->foliage_bytes == entry.foliage_bytes && again->warnings.size() == entry.warnings.size());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> text(data + 1, size - 1);
  const std::string record = data[0] % 2 == 0 ? std::string(text.begin(), text.end()) : with_checksum(text);
  const std::string key = coppice::bake::key_of(coppice::bake::parts_of_record(coppice::bake::bytes_of(record)));
  coppice::test::scratch_file(key + ".coppice", kPlant);
  const auto path = coppice::test::scratch_file(key + ".record", coppice::bake::bytes_of(record));
  if (const auto entry = coppice::bake::load_cached(scratch_folder(), key)) {
    check_entry(key, *entry);
  } else {
    COPPICE_ASSERT(entry.error().status == coppice::Status::bad_file && !entry.error().message().empty());
    COPPICE_ASSERT(!std::filesystem::exists(path));
  }
  return 0;
}
