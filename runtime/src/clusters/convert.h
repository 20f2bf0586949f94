#pragma once

// Converts structs of the file and of the decoder to those of the shaders: one function per pair.

#include "coppice/format.h"
#include "coppice_shared.h"
#include "crown_light.h"
#include "tree.h"
#include "wood_codec.h"

namespace coppice::gpu {

Card gpu_card(const coppice_file_card& card);
Material gpu_material(const coppice_file_material& material);
WoodVertex gpu_wood_vertex(const coppice::WoodVertex& vertex);
LeafMeshVertex gpu_leaf_mesh_vertex(const coppice::WoodVertex& vertex);

/// Sets geometry and table sizes; addresses, draws and residency stay zero.
Plant gpu_plant(const coppice_file_plant& plant);
LeafBox leaf_box(const Plant& plant);

/// Splits an address for the shaders: (low, high).
uvec2 gpu_address(std::uint64_t address);

}  // namespace coppice::gpu
