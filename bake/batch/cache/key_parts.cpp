#include "key_parts.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <new>
#include <system_error>
#include <tuple>

#include <xxhash.h>

#include "atomic_file.h"
#include "bake_cache.h"
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

namespace fs = std::filesystem;

/// Kind and name; of several with the same, which of them: a glTF may name one file twice.
using PartName = std::tuple<std::string, std::string, std::size_t>;

std::map<PartName, std::string> by_name(std::span<const KeyPart> parts) {
  std::map<PartName, std::string> values;
  for (const KeyPart& part : parts) {
    std::size_t ordinal = 0;
    while (values.contains({part.kind, part.name, ordinal})) ++ordinal;
    values[{part.kind, part.name, ordinal}] = part.value;
  }
  return values;
}

/// How a difference reads; a value that is null is not there.
std::string difference(const std::string& kind, const std::string& name, const std::string* now, const std::string* before) {
  const auto changed = [&](const std::string& what) {
    return what + ": " + (now != nullptr ? *now : "not given") + ", was " + (before != nullptr ? *before : "not given");
  };
  if (kind == "input") return "the input's bytes differ";
  if (kind == "name") return changed("name of the input");
  if (kind == "baker") return changed("the baker's version");
  if (kind == "format") return changed("the file format's version");
  if (kind == "device") return changed("the device that measures areas");
  if (kind == "option") return changed("option " + name);
  const std::string file = "texture or buffer " + name;
  const std::string missing = "missing";
  if (before == nullptr) return file + " is new to the input";
  if (now == nullptr) return file + " is no longer named by the input";
  if (*now == missing) return file + " is missing now";
  return *before == missing ? file + " was missing" : file + " differs";
}

std::vector<std::string> differences(const std::map<PartName, std::string>& now, const std::map<PartName, std::string>& before) {
  std::vector<std::string> all;
  for (const auto& [part, value] : now) {
    const auto other = before.find(part);
    if (other == before.end() || other->second != value)
      all.push_back(difference(std::get<0>(part), std::get<1>(part), &value, other == before.end() ? nullptr : &other->second));
  }
  for (const auto& [part, value] : before)
    if (!now.contains(part)) all.push_back(difference(std::get<0>(part), std::get<1>(part), nullptr, &value));
  std::ranges::sort(all);
  return all;
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

std::vector<KnownKey> known_keys(const fs::path& folder) {
  std::vector<KnownKey> known;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string key = entry->path().stem().string();
    if (entry->path().extension() != ".record" || !is_key(key)) continue;
    const auto record = read_kept_file(entry->path(), FileOwner::anybody, kMaxRecordBytes + 1);
    std::vector<KeyPart> parts = record ? parts_of_record(*record) : std::vector<KeyPart>();
    if (parts.empty()) continue;
    std::error_code gone;
    const auto used = entry->last_write_time(gone).time_since_epoch();
    known.push_back({key, std::chrono::duration_cast<std::chrono::nanoseconds>(used).count(), std::move(parts)});
  }
  return known;
}

std::vector<std::string> why_baked(std::span<const KeyPart> parts, std::span<const KnownKey> known) {
  const std::map<PartName, std::string> now = by_name(parts);
  const PartName name{"name", "", 0}, input{"input", "", 0};
  const KnownKey* nearest = nullptr;
  std::vector<std::string> least;
  for (const KnownKey& entry : known) {
    const std::map<PartName, std::string> before = by_name(entry.parts);
    const auto same = [&](const PartName& part) { return now.contains(part) && before.contains(part) && now.at(part) == before.at(part); };
    if (!same(name) && !same(input)) continue;
    std::vector<std::string> all = differences(now, before);
    const auto rank = [](std::size_t count, const KnownKey& of) { return std::tuple(count, -of.used_ns, of.key); };
    if (nearest != nullptr && rank(least.size(), *nearest) <= rank(all.size(), entry)) continue;
    nearest = &entry;
    least = std::move(all);
  }
  if (nearest == nullptr) return {"the cache has no entry of this plant"};
  if (least.empty()) return {"its entry is gone or damaged"};
  return least;
}

}  // namespace coppice::bake
