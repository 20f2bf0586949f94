#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gltf_instances.h"
#include "result.h"

namespace coppice::bake {

/// The lines of a primitive that became leaves.
struct WidenedLines {
  std::uint32_t mesh = 0;
  std::uint32_t count = 0;  ///< lines
  double width = 0.0;       ///< the one that all but the shortest have, in units of the mesh
};

/// Some plants have needles and blades of grass that are line primitives. This makes thin strips of triangles of them, one strip a line, so
/// that the importer finds leaves in them as in any other triangles. Segments that meet end to end, without others, and turn by less than
/// 60 degrees are one line. All lines of a primitive have one width: of their median length a twentieth if most have one segment, as
/// needles, else a fortieth, as blades; but at most a quarter of their own length. Strips next to each other are turned about their lines
/// by different angles, so that a plant is as dense from any side. New vertices have the attributes of those that they stand beside,
/// without normals, tangents and morph targets.
/// errors  as read_positions and read_vertex_order; bad_file: attributes of unequal length
Result<std::vector<WidenedLines>> widen_lines(tinygltf::Model& model);

/// A line for a person about those that the instances show; empty: none.
std::string lines_text(const std::vector<WidenedLines>& lines, const std::vector<MeshInstance>& instances);

}  // namespace coppice::bake
