#pragma once

// What a bake's key is made of, part by part, so that two keys can be compared: what differs between them is why one of them was baked.

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace coppice::bake {

/// One thing that a bake's bytes depend on. All three are UTF-8: portable_text().
struct KeyPart {
  std::string kind;   ///< baker, format, option, device, name, input or file
  std::string name;   ///< an option's or a file's; empty elsewhere
  std::string value;  ///< an input or a file has its checksum, or "missing"
  bool operator==(const KeyPart&) const = default;
};

/// XXH3-128 of a sequence of texts in 32 hexadecimal digits; where one text ends and the next begins counts.
std::string checksum_of(std::span<const std::string_view> texts);

/// The parts' checksum. Equal keys mean equal parts, and equal parts equal bytes of the bake.
std::string key_of(std::span<const KeyPart> parts);

/// Whether a text can be a key: 32 hexadecimal digits, small letters.
bool is_key(std::string_view text);

/// The text itself where it is UTF-8, else its bytes in hexadecimal digits behind U+FFFD. No two texts give the same.
std::string portable_text(std::string_view text);

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
