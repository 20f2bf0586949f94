// libFuzzer: any bytes that the server of a cache may answer with are refused, or read as an entry, an index or a listing that holds
// together. Byte 0 says which of them; with its fourth bit set the checksum of an index is made right.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "bake_cache.h"
#include "cache_index.h"
#include "check.h"
#include "checksum.h"
#include "key_parts.h"

namespace {

using namespace coppice::bake;

void check_bundle(std::span<const std::uint8_t> bytes) {
  const std::string key(32, 'a');
  const auto entry = read_bundle(bytes, key);
  COPPICE_ASSERT(entry || !entry.error().message().empty());
  if (entry) COPPICE_ASSERT(key_of(entry->parts) == key);
}

void check_index(std::string text, bool mend) {
  constexpr std::string_view kLastLine = "checksum ";
  if (mend) {
    text.erase(std::min(text.rfind(kLastLine), text.size()));
    Checksum checksum;
    checksum.add(text);
    text.append(kLastLine).append(checksum.text()).append("\n");
  }
  const auto index = read_index(text);
  if (!index) return;
  for (const auto& [key, bytes] : *index) COPPICE_ASSERT(is_key(key));
  const auto again = read_index(index_text(*index));
  COPPICE_ASSERT(again && *again == *index);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  const std::string text(bytes.begin(), bytes.end());
  if (data[0] % 4 == 0) check_bundle(bytes);
  if (data[0] % 4 == 1) check_index(text, (data[0] & 8u) != 0);
  if (data[0] % 4 == 2) {
    const auto files = read_listing(text);
    if (!files) COPPICE_ASSERT(!files.error().message().empty());
  }
  if (data[0] % 4 == 3) static_cast<void>(parts_of_record(bytes));
  return 0;
}
