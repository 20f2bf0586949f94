#pragma once

// What the names of nodes and meshes say about their role in a pack: "oak_B_LOD1", "UCX_oak", "Oak Billboard.001".

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace coppice::bake {

enum class NodeRole : std::uint8_t {
  shape,           ///< the name says nothing else
  billboard,       ///< "billboard", "impostor"
  collision,       ///< "UCX_", "collider", "colonly", ...
  maybe_collision  ///< "col", "hull": also colours and husks
};

/// A level only beside others of its series: "oak_L1", "oak_mid".
struct WeakLevel {
  std::uint32_t level = 0;
  bool is_word = false;  ///< "mid"; levels of words need not follow each other
  std::string stem;      ///< the other words, as NodeName::stem
};

struct NodeName {
  std::optional<std::uint32_t> level;   ///< 1 of "oak_LOD1", "oakLod1", "lod.1", "oak (LOD 1)", "oak_lod_mid"
  std::optional<WeakLevel> weak_level;  ///< nothing where there is a level
  NodeRole role = NodeRole::shape;
  std::string stem;  ///< the words without role and level, lower case, apart by spaces: the levels of one thing share them
};

NodeName read_node_name(std::string_view name);

/// The words of a name, lower case: "OakTree_02b" is oak, tree, 02, b. They end at what is neither letter nor digit, between letters and
/// digits, and before a capital that follows a small letter. Only the first 256 bytes of a name count.
std::vector<std::string> name_words(std::string_view name);
/// Words apart by spaces, as in NodeName::stem.
std::string joined(const std::vector<std::string>& words);

/// Whether a word distinguishes things of one kind: a number, a single letter, "small", "old", "winter", "variant", ...
bool is_variant_word(std::string_view word);

/// The name without its level and Blender's number of a copy: "oak_B" for "oak_B_LOD0", "oak_B.LOD0.001". Empty if nothing else is in it.
std::string without_level(std::string_view name);

/// Whether the name says that it is a variant: "var", "variant", "variation".
bool says_variant(std::string_view name);

/// Whether a name says only which part of a plant something is (material_words.h), or only which tool made it: "leaves_02", "Circle.003".
/// Such names may be numbered without being variants.
bool is_part_name(std::string_view name);

/// Whether a mesh or material is named after wind: one of its words is "wind", "sway", "bend" or "flutter".
bool names_wind(std::string_view name);

}  // namespace coppice::bake
