#include "key_parts.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <new>

#include <xxhash.h>

#include "text_bytes.h"
#include "utf8.h"

namespace coppice::bake {
namespace {

bool is_utf8(std::string_view text) {
  std::span<const std::uint8_t> rest = bytes_of(text);
  while (!rest.empty()) {
    const std::size_t length = utf8_sequence_length(rest);
    if (length == 0) return false;
    rest = rest.subspan(length);
  }
  return true;
}

}  // namespace

std::string checksum_of(std::span<const std::string_view> texts) {
  const auto free_state = [](XXH3_state_t* state) { static_cast<void>(XXH3_freeState(state)); };
  const std::unique_ptr<XXH3_state_t, decltype(free_state)> state(XXH3_createState(), free_state);
  if (!state || XXH3_128bits_reset(state.get()) != XXH_OK) throw std::bad_alloc();
  for (const std::string_view text : texts) {
    const std::uint64_t length = text.size();
    static_cast<void>(XXH3_128bits_update(state.get(), &length, sizeof length));
    static_cast<void>(XXH3_128bits_update(state.get(), text.data(), text.size()));
  }
  const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
  std::array<char, 33> digits{};
  static_cast<void>(std::snprintf(digits.data(), digits.size(), "%016llx%016llx", static_cast<unsigned long long>(hash.high64),
                                  static_cast<unsigned long long>(hash.low64)));
  return digits.data();
}

std::string key_of(std::span<const KeyPart> parts) {
  std::vector<std::string_view> texts;
  for (const KeyPart& part : parts) texts.insert(texts.end(), {part.kind, part.name, part.value});
  return checksum_of(texts);
}

bool is_key(std::string_view text) {
  constexpr std::size_t kDigits = 32;
  return text.size() == kDigits && std::ranges::all_of(text, [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); });
}

std::string portable_text(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbf\xbd", kDigits = "0123456789abcdef";
  if (is_utf8(text) && !text.starts_with(kMark)) return std::string(text);
  std::string portable(kMark);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    portable += kDigits[byte >> 4];
    portable += kDigits[byte & 15u];
  }
  return portable;
}

}  // namespace coppice::bake
