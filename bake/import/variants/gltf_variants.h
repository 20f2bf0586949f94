#pragma once

// Chooses which nodes of a file are one plant. Packs hold a plant several times: as levels of detail, as a billboard, as a collision shape;
// and several plants beside or on top of each other. The finest level of one variant is the plant. A plant of many nodes stays whole.
//
// Levels     "_LOD1" and the like in a node's, a mesh's or a parent's name, and what MSFT_lod names: only the finest of each name stays.
//            "_L1" counts if siblings are a series of one extent with falling triangle counts.
// Billboards by name, and by shape: a few large masked triangles as big as the plant that they stand in.
// Collision  by name.
// Variants   the scene's top nodes (below nodes that hold all), or groups of them by number in their names or by the ground that they stand
//            on, if each is a whole plant: no two show the same meshes, all stand on one ground, none is wood alone beside leaves alone;
//            and if they stand apart, or on the very same spot. Stems of one plant stand close together instead. Those that are levels of
//            detail by all but their names are in order of falling triangle counts.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gltf_nodes.h"
#include "result.h"

namespace coppice::bake {

/// What a file holds: its variants, and what is left out beside them.
struct SourceContents {
  struct Variant {
    std::string name;
    std::uint64_t triangles = 0;
    std::array<double, 3> size_m{};
  };
  struct Left {
    LeftReason reason = LeftReason::none;
    std::string name;
    std::uint64_t triangles = 0;
  };
  std::vector<Variant> variants;  ///< empty where there was nothing to choose from
  std::uint32_t taken = 0;        ///< index of the variant that is the plant
  std::string copied_plant;       ///< a node that the file, a level, shows several times; else empty
  std::size_t copy_count = 0;     ///< it and the nodes that show the same
  std::vector<Left> left;         ///< levels, billboards and the like of all variants
  std::string scenery;            ///< a line about other scenes, cameras and lights; empty if there are none
};

/// Says which part of a file to bake.
struct PlantChoice {
  /// Takes only what is below nodes of this name (or that show a mesh of this name). If there is none, the name is a regular expression
  /// (name_pattern.h) that is searched in names. Of several copies of a whole plant (gltf_copies.h) it takes the first.
  std::optional<std::string> node;
  std::uint32_t variant = 1;  ///< from 1 on
  bool whole = false;         ///< the whole file is one plant
};

struct ChosenNodes {
  std::vector<MeshInstance> instances;  ///< those taken, in order
  SourceContents contents;
};

/// instances  all those of mesh_instances
/// errors  invalid_argument: no node has the name; the file has fewer variants (they are listed)
Result<ChosenNodes> choose_plant(const tinygltf::Model& model, std::vector<MeshInstance> instances, const PlantChoice& choice);

/// One line that says that the file is a level, and what to do with it; empty if it is none.
std::string level_line(const SourceContents& contents);

/// One line that says what is taken and what is left out; empty if all is taken.
std::string contents_line(const SourceContents& contents);

/// [variants] The output of each variant if a single plant would go to `output`: "oaks.coppice" becomes "oaks_large.coppice", or
/// "oaks_B.coppice" for 'Oaks_B'. Characters of a name other than letters, digits, "-" and "." become "_"; all outputs are different.
std::vector<std::filesystem::path> variant_outputs(const std::filesystem::path& output, const SourceContents& contents);

/// A line for each variant and for what else is left out; empty if all is taken.
std::string contents_table(const SourceContents& contents);

}  // namespace coppice::bake
