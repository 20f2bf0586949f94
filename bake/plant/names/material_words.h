#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace coppice::bake {

/// How many bytes of a name are read.
inline constexpr std::size_t kMaxNameBytes = 256;

/// What a word in a material's name speaks for.
enum class WordKind {
  leaf,    ///< foliage: "leaf", "needle", "Blatt", ...
  flower,  ///< thin like leaves and drawn like them, but not always cards: "petal", ...
  plant,   ///< all of a plant that is mostly leaves, often with its stems: "bush", "hedge", "reed", ...
  twig,    ///< bears leaves; cards of whole twigs are called so too: "branch", "Zweig", ...
  other,   ///< never foliage: bark, trunk, roots, pots, soil, snow, fruit, ...
};

/// Parts of names, lower case. A whole word matches only a word of its own ("pot" is in "flower_pot", not in "potato"); words end at
/// anything that is no letter and before a capital that follows a small letter.
struct MaterialWords {
  WordKind kind;
  bool whole;
  std::span<const std::string_view> texts;
};

/// All words that count, in English, German, French, Spanish, Portuguese, Italian, Dutch, Swedish, Finnish, Turkish, Polish, Russian,
/// Greek, Chinese, Japanese and Korean.
std::span<const MaterialWords> material_words();

/// Sums the weights of the kinds of words that the name has. A kind counts once; words for whole plants count only where the others sum to
/// 0. Ignores the case of Latin, Greek and Cyrillic letters.
/// returns  in [-4, 4]: above 0 speaks for leaves, below for wood; 0: the name says nothing
double name_evidence(std::string_view name);

/// name_evidence without the words for whole plants, which are the names of plants too.
double part_evidence(std::string_view name);

}  // namespace coppice::bake
