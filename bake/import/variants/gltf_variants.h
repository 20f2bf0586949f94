#pragma once

// Which nodes of a file are one plant. Packs hold a plant several times: as levels of detail, as a billboard, as a shape to collide with,
// and several plants beside or on top of each other. Of those the finest level of one variant is a plant. A plant of many nodes stays
// whole.
//
// Levels     "_LOD1" and its like in a node's, a mesh's or a parent's name, and what MSFT_lod names: all but the least of each name go.
//            "_L1" counts where siblings are a series of one extent with falling triangle counts.
// Billboards by name, and by shape: a few large masked triangles as big as the plant that they stand in.
// Collision  by name.
// Variants   the scene's top nodes (below nodes that hold all), or groups of them by number in their names or by the ground that they stand
//            on, if each is a whole plant: no two show the same meshes, all stand on one ground, none is wood alone beside leaves alone;
//            and if they stand apart, or on the very same spot. Stems of one plant stand close together instead.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gltf_instances.h"
#include "result.h"
#include "source_contents.h"

namespace coppice::bake {

/// What of a file is to be baked.
struct PlantChoice {
  /// Only what is below nodes of this name (or that show a mesh of this name); if there is none, of names that it, a regular expression
  /// (name_pattern.h), finds.
  std::optional<std::string> node;
  std::uint32_t variant = 1;  ///< from 1 on
  bool whole = false;         ///< all of it is one plant
};

struct ChosenNodes {
  std::vector<MeshInstance> instances;  ///< those taken, in order
  SourceContents contents;
};

/// instances  of mesh_instances, all of them
/// errors  invalid_argument: no node has the name; the file has fewer variants (they are listed)
Result<ChosenNodes> choose_plant(const tinygltf::Model& model, std::vector<MeshInstance> instances, const PlantChoice& choice);

/// One line that says what is taken and what is left; empty where all is.
std::string contents_line(const SourceContents& contents);

/// [variants] Where each goes if the file's one plant would go to `output`: "oaks.coppice" becomes "oaks_large.coppice", or
/// "oaks_B.coppice" for 'Oaks_B'. What is no letter, digit, "-" or "." of a name becomes "_"; all are different.
std::vector<std::filesystem::path> variant_outputs(const std::filesystem::path& output, const SourceContents& contents);

/// A line for each variant and for what else is left out; empty where all is taken.
std::string contents_table(const SourceContents& contents);

}  // namespace coppice::bake
