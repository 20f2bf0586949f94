#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace coppice::bake {

/// Only so much of a name counts.
inline constexpr std::size_t kMaxNameBytes = 256;

/// What a word in a material's name speaks for.
enum class WordKind {
  leaf,    ///< foliage: "leaf", "needle", "Blatt", ...
  flower,  ///< thin like leaves and drawn like them, but not always cards: "petal", ...
  plant,   ///< all of a plant that is mostly leaves, often with its stems: "bush", "hedge", "reed", ...
  twig,    ///< bears leaves; cards of whole twigs are called so too: "branch", "Zweig", ...
  other,   ///< never foliage: bark, trunk, roots, pots, soil, snow, fruit, ...
};

/// A part of a name, lower case. A whole word matches only a word of its own ("pot" is in "flower_pot", not in "potato"); words end at
/// anything that is no letter and before a capital that follows a small letter.
struct MaterialWord {
  std::string_view text;
  WordKind kind;
  bool whole = false;
};

/// All words that count, in English, German, French, Spanish, Portuguese, Italian, Dutch, Swedish, Finnish, Turkish, Polish, Russian,
/// Greek, Chinese, Japanese and Korean.
std::span<const MaterialWord> material_words();

/// The sum over the kinds of words that are in the name of what each is worth; a kind counts once, a plant's only
/// where the others come to nothing. In any case of Latin, Greek and Cyrillic
/// letters.
/// returns  0 for a name that says nothing; above 0 speaks for leaves, below for wood; in [-4, 4]
double name_evidence(std::string_view name);

/// The same without the words for all of a plant, which are the names of plants.
double part_evidence(std::string_view name);

}  // namespace coppice::bake
