#include "gltf_unread.h"

#include <algorithm>
#include <cstddef>

#include <tiny_gltf.h>

namespace coppice::bake {
namespace {

/// Appends "2 cameras" to a list; nothing for 0.
void add_count(std::size_t count, const std::string& what, std::string& list) {
  if (count > 0) list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

std::string scenery_text(const tinygltf::Model& model) {
  std::string list;
  add_count(model.scenes.size() - std::min<std::size_t>(model.scenes.size(), 1), "other scene", list);
  const auto count_nodes = [&model](const auto& is_one) { return static_cast<std::size_t>(std::ranges::count_if(model.nodes, is_one)); };
  add_count(count_nodes([](const tinygltf::Node& node) { return node.camera >= 0; }), "camera", list);
  add_count(count_nodes([](const tinygltf::Node& node) { return node.extensions.count("KHR_lights_punctual") > 0; }), "light", list);
  return list.empty() ? list : "left out: " + list;
}

std::string points_text(const tinygltf::Model& model, const std::vector<MeshInstance>& instances) {
  std::size_t count = 0;
  for (const MeshInstance& instance : instances)
    for (const tinygltf::Primitive& primitive : model.meshes.at(instance.mesh).primitives)
      count += primitive.mode < TINYGLTF_MODE_TRIANGLES ? 1u : 0u;
  std::string list;
  add_count(count, "primitive", list);
  return list.empty() ? list : "left out: " + list + " of points, or of lines without length";
}

std::string emission_text(const tinygltf::Model& model, const std::vector<std::uint32_t>& materials) {
  constexpr std::size_t kMaxNames = 8;
  std::size_t count = 0;
  std::string names;
  for (const std::uint32_t index : materials) {
    if (index == kNone) continue;
    const tinygltf::Material& material = model.materials.at(index);
    if (!std::ranges::any_of(material.emissiveFactor, [](double factor) { return factor > 0.0; })) continue;
    if (count++ < kMaxNames) names += (names.empty() ? "'" : ", '") + material.name.substr(0, 64) + "'";
  }
  if (count > kMaxNames) names += ", ...";
  return count == 0 ? names : "the light that materials emit is left out: " + names;
}

}  // namespace coppice::bake
