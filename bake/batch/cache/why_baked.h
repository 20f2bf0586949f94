#pragma once

// Why a plant was baked: what its key is of, beside what the keys of a cache's entries are of.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "key_parts.h"

namespace coppice::bake {

/// An entry of a folder, as far as keys are compared.
struct KnownKey {
  std::string key;
  std::int64_t used_ns = 0;  ///< last use, as file systems count
  std::vector<KeyPart> parts;
};

/// Every entry of a folder that says what its key is of; none where it cannot be read. Reads all records and no plant.
std::vector<KnownKey> known_keys(const std::filesystem::path& folder);

/// What differs between a bake's parts and those of the nearest entry, one line each: "the input's bytes differ", "texture or buffer
/// bark.png differs", "option views: 42, was 20". The nearest differs in the fewest parts; of equally near ones the last used one counts.
/// Only entries of the plant's name or of its input's bytes are near. Where there is none, one line says so.
std::vector<std::string> why_baked(std::span<const KeyPart> parts, std::span<const KnownKey> known);

}  // namespace coppice::bake
