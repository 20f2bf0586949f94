#pragma once

#include <string>
#include <vector>

#include "gltf_instances.h"

namespace coppice::bake {

/// What a document holds that no plant has, as lines for a person. Each is empty if there is none.

/// Other scenes, cameras and lights.
std::string scenery_text(const tinygltf::Model& model);
/// Points that the instances show.
std::string points_text(const tinygltf::Model& model, const std::vector<MeshInstance>& instances);
/// Light that materials emit. materials  indices, kNone for glTF's default material
std::string emission_text(const tinygltf::Model& model, const std::vector<std::uint32_t>& materials);

}  // namespace coppice::bake
