#include "node_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <span>

#include "material_words.h"

namespace coppice::bake {
namespace {

// Unreal's prefixes of collision shapes: convex, box, sphere, capsule.
constexpr std::array<std::string_view, 4> kUnrealShapes{"ucx", "ubx", "usp", "ucp"};
constexpr std::array<std::string_view, 8> kCollisionWords{"collision",   "collisions", "collider",      "colliders",
                                                          "convcolonly", "colonly",    "collisionmesh", "physicsmesh"};
constexpr std::array<std::string_view, 2> kMaybeCollisionWords{"col", "hull"};
constexpr std::array<std::string_view, 6> kBillboardWords{"billboard", "billboards", "impostor", "impostors", "imposter", "imposters"};
constexpr std::array<std::string_view, 21> kSizeWords{"small", "medium",  "large",  "big",    "tall",  "short",  "young",
                                                      "old",   "tiny",    "huge",   "mid",    "adult", "little", "mature",
                                                      "dead",  "sapling", "spring", "summer", "fall",  "autumn", "winter"};
constexpr std::array<std::string_view, 12> kVariantWords{"variant",  "variants", "variation", "var",   "version", "type",
                                                         "variante", "option",   "form",      "style", "model",   "v"};
/// Words for the quality of a level, from the finest on.
struct QualityWord {
  std::string_view word;
  std::uint32_t level;
};
constexpr std::array<QualityWord, 20> kQualityWords{{{"high", 0},   {"hi", 0},      {"highpoly", 0}, {"hipoly", 0},  {"highres", 0},
                                                     {"hires", 0},  {"hp", 0},      {"near", 0},     {"mid", 1},     {"med", 1},
                                                     {"medium", 1}, {"midpoly", 1}, {"low", 2},      {"lo", 2},      {"lowpoly", 2},
                                                     {"lowres", 2}, {"lp", 2},      {"far", 2},      {"verylow", 3}, {"proxy", 3}}};
// Words that go with these: "high poly", "low_res".
constexpr std::array<std::string_view, 5> kQualityNouns{"poly", "res", "resolution", "detail", "quality"};
// Words before the number of a level that have other meanings as well.
constexpr std::array<std::string_view, 4> kWeakLevelWords{"l", "lvl", "level", "detail"};
// Names that programs give by themselves, and words for pieces of anything.
constexpr std::array<std::string_view, 41> kEmptyWords{
    "object",       "mesh",      "node",     "cube",     "plane",       "circle",  "cylinder",  "sphere",  "cone",
    "curve",        "empty",     "group",    "polygon",  "shape",       "part",    "piece",     "section", "layer",
    "ring",         "primitive", "geometry", "geo",      "polysurface", "torus",   "icosphere", "grid",    "beziercurve",
    "beziercircle", "nurbspath", "element",  "material", "mat",         "submesh", "chunk",     "card",    "cards",
    "crown",        "blade",     "nodes",    "meshes",   "objects"};

// Words of foliage that are whole plants as well.
constexpr std::array<std::string_view, 10> kPlantWords{"grass", "gras",   "grasses", "fern",  "ferns",
                                                       "ivy",   "flower", "flowers", "fleur", "flor"};

bool is_one_of(std::string_view word, std::span<const std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

bool is_number(std::string_view word) {
  return !word.empty() && std::ranges::all_of(word, [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// A level's number: three digits or more number copies.
std::optional<std::uint32_t> level_number(const std::string& word) {
  std::uint32_t number = 0;
  if (!is_number(word) || word.size() > 2) return {};
  std::from_chars(word.data(), word.data() + word.size(), number);
  return number;
}

using WordList = std::vector<std::string>;

void erase(WordList& words, std::size_t first, std::size_t count) {
  words.erase(words.begin() + static_cast<std::ptrdiff_t>(first), words.begin() + static_cast<std::ptrdiff_t>(first + count));
}

std::optional<std::uint32_t> quality_of(const std::string& word) {
  const auto found = std::ranges::find(kQualityWords, word, &QualityWord::word);
  return found == kQualityWords.end() ? std::nullopt : std::optional(found->level);
}

/// Takes "lod 1", "oaklod1" or "lod mid" out of `words`.
bool take_level(WordList& words, NodeName& name) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    std::string& word = words[i];
    if (!word.ends_with("lod")) continue;
    const auto number = level_number(words[i + 1]);
    name.level = number ? number : quality_of(words[i + 1]);
    if (!name.level) continue;
    // "oaklod1": the letters before "lod" are the stem's.
    word.resize(word.size() - 3);
    erase(words, i + 1, 1);
    if (word.empty()) erase(words, i, 1);
    return true;
  }
  return false;
}

std::optional<WeakLevel> weak_level(WordList words) {
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const auto number = is_one_of(words[i], kWeakLevelWords) ? level_number(words[i + 1]) : std::nullopt;
    if (!number) continue;
    erase(words, i, 2);
    return WeakLevel{*number, false, joined(words)};
  }
  for (std::size_t i = words.size(); i-- > 0;) {
    const auto quality = quality_of(words[i]);
    if (!quality) continue;
    erase(words, i, i + 1 < words.size() && is_one_of(words[i + 1], kQualityNouns) ? 2 : 1);
    return WeakLevel{*quality, true, joined(words)};
  }
  return {};
}

NodeRole role_of(const std::vector<std::string>& words, std::size_t index) {
  if (index == 0 && words.size() > 1 && is_one_of(words[0], kUnrealShapes)) return NodeRole::collision;
  if (is_one_of(words[index], kCollisionWords)) return NodeRole::collision;
  if (is_one_of(words[index], kBillboardWords)) return NodeRole::billboard;
  if (is_one_of(words[index], kMaybeCollisionWords)) return NodeRole::maybe_collision;
  return NodeRole::shape;
}

}  // namespace

std::vector<std::string> name_words(std::string_view name) {
  enum class Kind { none, capital, small, digit };
  const auto kind_of = [](char c) {
    if (c >= '0' && c <= '9') return Kind::digit;
    if (c >= 'A' && c <= 'Z') return Kind::capital;
    return (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80 ? Kind::small : Kind::none;
  };
  std::vector<std::string> words;
  Kind before = Kind::none;
  for (const char c : name.substr(0, kMaxNameBytes)) {
    const Kind kind = kind_of(c);
    const bool goes_on = kind == before || (kind == Kind::small && before == Kind::capital);
    if (kind != Kind::none && !goes_on) words.emplace_back();
    if (kind != Kind::none) words.back() += kind == Kind::capital ? static_cast<char>(c - 'A' + 'a') : c;
    before = kind;
  }
  return words;
}

std::string joined(const WordList& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

NodeName read_node_name(std::string_view name) {
  std::vector<std::string> words = name_words(name);
  NodeName read;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const NodeRole role = role_of(words, i);
    if (role == NodeRole::shape) continue;
    read.role = role;
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i));
    break;
  }
  if (!take_level(words, read)) read.weak_level = weak_level(words);
  read.stem = joined(words);
  return read;
}

bool is_variant_word(std::string_view word) {
  return is_number(word) || (word.size() == 1 && word[0] >= 'a' && word[0] <= 'z') || is_one_of(word, kSizeWords) ||
         is_one_of(word, kVariantWords);
}

std::string without_level(std::string_view name) {
  // What the editors append comes first off: a level may stand before it.
  const auto trim = [](std::string_view text) {
    while (!text.empty() && std::string_view(" _-.()[]").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
    return text;
  };
  std::string_view rest = name;
  const std::size_t dot = rest.rfind('.');
  if (dot != std::string_view::npos && rest.size() - dot == 4 && is_number(rest.substr(dot + 1))) rest = rest.substr(0, dot);
  constexpr std::size_t kMaxLevelBytes = 16;
  for (std::size_t length = 1; length <= std::min(rest.size(), kMaxLevelBytes); ++length) {
    const std::size_t at = rest.size() - length;
    const NodeName read = read_node_name(rest.substr(at));
    if (read.level && read.stem.empty()) return std::string(trim(rest.substr(0, at)));
  }
  return std::string(name);
}

bool says_variant(std::string_view name) {
  constexpr std::array<std::string_view, 4> kSure{"var", "variant", "variation", "variante"};
  return std::ranges::any_of(name_words(name), [&](const std::string& word) { return is_one_of(word, kSure); });
}

bool is_part_name(std::string_view name) {
  std::vector<std::string> words = name_words(name);
  std::string parts;
  for (const std::string& word : words)
    if (!is_one_of(word, kPlantWords)) parts += word + " ";
  if (part_evidence(parts) != 0.0) return true;
  return std::ranges::all_of(words, [](const std::string& word) { return is_variant_word(word) || is_one_of(word, kEmptyWords); });
}

bool names_wind(std::string_view name) {
  std::string word;
  const auto is_wind = [&] { return word == "wind" || word == "sway" || word == "bend" || word == "flutter"; };
  bool was_small = false;
  for (const char letter : name) {
    const bool capital = letter >= 'A' && letter <= 'Z', small = letter >= 'a' && letter <= 'z';
    if (!(capital || small) || (capital && was_small)) {
      if (is_wind()) return true;
      word.clear();
    }
    if (capital || small) word += static_cast<char>(capital ? letter - 'A' + 'a' : letter);
    was_small = small;
  }
  return is_wind();
}

}  // namespace coppice::bake
