#include "why_baked.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <system_error>
#include <tuple>

#include "atomic_file.h"
#include "bake_cache.h"

namespace coppice::bake {
namespace {

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

std::vector<KnownKey> known_keys(const fs::path& folder) {
  std::vector<KnownKey> known;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string key = entry->path().stem().string();
    if (entry->path().extension() != ".record" || !is_key(key)) continue;
    const auto record = read_file(entry->path());
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
