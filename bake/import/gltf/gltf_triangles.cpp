#include "gltf_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <tuple>
#include <utility>

#include <tiny_gltf.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "bounds.h"
#include "gltf_accessor.h"
#include "gltf_materials.h"
#include "node_names.h"
#include "text_number.h"
#include "tree.h"

namespace coppice::bake {
namespace {

// Limits coordinates so that squared areas still fit a float. No plant is this far from its origin in any unit.
constexpr double kMaxCoordinate_m = 1e8;

// A vertex without a wind weight.
constexpr float kNoWeight = -1.0f;

/// A primitive as the file holds it.
struct RawPrimitive {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  ///< empty when missing
  std::vector<glm::vec2> uvs;
  std::vector<glm::vec4> colors;         ///< linear, 0..1
  std::vector<std::uint32_t> triangles;  ///< 3 vertices each
};

/// Vertex numbers of the primitive's triangles (glTF 2.0, 3.7.2.1). Strips alternate their winding; triangles of a strip or fan that
/// repeat a vertex are seams, not surface.
std::vector<std::uint32_t> triangulate(int mode, const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> triangles;
  if (mode == TINYGLTF_MODE_TRIANGLES) {
    triangles.assign(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(order.size() / 3 * 3));
    return triangles;
  }
  for (std::size_t i = 0; i + 2 < order.size(); ++i) {
    const bool strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
    const std::uint32_t a = strip ? order[i] : order[0];
    const std::uint32_t b = strip ? order[i + 1 + i % 2] : order[i + 1];
    const std::uint32_t c = strip ? order[i + 2 - i % 2] : order[i + 2];
    if (a != b && b != c && c != a) triangles.insert(triangles.end(), {a, b, c});
  }
  return triangles;
}

int attribute_accessor(const tinygltf::Primitive& primitive, const std::string& name) {
  const auto found = primitive.attributes.find(name);
  return found == primitive.attributes.end() ? -1 : found->second;
}

/// Reads an optional attribute; empty if it is absent. read  read_vectors or the like
template <class Values>
Result<Values> read_attribute(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const std::string& name,
                              std::size_t vertex_count, Result<Values> (*read)(const tinygltf::Model&, int)) {
  const int accessor = attribute_accessor(primitive, name);
  if (accessor < 0) return Values{};
  const std::size_t count = model.accessors.at(static_cast<std::size_t>(accessor)).count;
  if (count == vertex_count) return read(model, accessor);
  return Error{Status::bad_file, "attributes of unequal length", Error::kNoOffset,
               name + formatted(" has %zu, POSITION %zu", count, vertex_count)};
}

/// Finds for each vertex the first one that lies in the same place.
std::vector<std::uint32_t> first_at_place(const std::vector<glm::vec3>& positions) {
  const auto key = [&](std::uint32_t vertex) { return std::tuple(positions[vertex].x, positions[vertex].y, positions[vertex].z, vertex); };
  std::vector<std::uint32_t> order(positions.size()), first(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, {}, key);
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && positions[order[i]] == positions[order[i - 1]] ? first[order[i - 1]] : order[i];
  return first;
}

/// Drops triangles whose corners lie where those of an earlier one do, in any order: some tools write each side of a surface as a triangle,
/// but the renderer shows both sides of each. Triangles without area stay, since leaf detection counts them.
void drop_repeated_triangles(RawPrimitive& raw) {
  const std::vector<std::uint32_t> first = first_at_place(raw.positions);
  std::vector<std::pair<std::array<std::uint32_t, 3>, std::uint32_t>> placed;  // places of corners, ascending; number
  for (std::uint32_t t = 0; t < raw.triangles.size() / 3; ++t) {
    placed.emplace_back(at_corners(first, raw.triangles, 3 * std::size_t{t}), t);
    std::ranges::sort(placed.back().first);
  }
  std::ranges::sort(placed);
  std::vector<bool> is_kept(placed.size(), true);
  for (std::size_t i = 1; i < placed.size(); ++i) {
    const auto& [places, triangle] = placed[i];
    const bool has_area = places[0] != places[1] && places[1] != places[2];
    is_kept[triangle] = !has_area || places != placed[i - 1].first;
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < is_kept.size(); ++t)
    if (is_kept[t]) std::copy_n(&raw.triangles[3 * t], 3, &raw.triangles[3 * kept++]);
  raw.triangles.resize(3 * kept);
}

/// Reads how flexible vertices are, 0..1; empty if the primitive does not say it in a readable way.
std::vector<float> read_wind_weights(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const PlacedPrimitive& placed,
                                     const std::string& place, std::vector<std::string>& warnings) {
  std::vector<std::string> names{"_WIND_WEIGHT", "_WIND"};
  if (placed.wind_color_set) names.insert(names.begin(), "COLOR_" + std::to_string(*placed.wind_color_set));
  const auto name = std::ranges::find_if(names, [&](const std::string& each) { return attribute_accessor(primitive, each) >= 0; });
  if (name == names.end()) return {};
  const auto count = model.accessors.at(static_cast<std::size_t>(attribute_accessor(primitive, "POSITION"))).count;
  auto weights = read_attribute(model, primitive, *name, count, read_first_components);
  if (!weights) {
    warnings.push_back(place + ": " + *name + " is not used as wind weights: " + weights.error().message());
    return {};
  }
  for (float& weight : *weights) weight = weight >= 0.0f ? std::min(weight, 1.0f) : 0.0f;  // also for NaN
  return *std::move(weights);
}

/// Reads _SPREAD as encode_glb writes it (gltf_write.h): Mesh::vertex_alongs; empty if the primitive does not say it in a readable way.
std::vector<float> read_alongs(const tinygltf::Model& model, const tinygltf::Primitive& primitive, std::size_t vertex_count,
                               const std::string& place, std::vector<std::string>& warnings) {
  auto alongs = read_attribute(model, primitive, "_SPREAD", vertex_count, read_first_components);
  if (!alongs) {
    warnings.push_back(place + ": _SPREAD is not used: " + alongs.error().message());
    return {};
  }
  for (float& along : *alongs) along = std::isfinite(along) ? std::clamp(along, -1.0f, 1.0f) : 1.0f;
  return *std::move(alongs);
}

Result<RawPrimitive> read_primitive(const tinygltf::Model& model, const tinygltf::Primitive& primitive, const PlacedPrimitive& placed) {
  RawPrimitive raw;
  const int position_accessor = attribute_accessor(primitive, "POSITION");
  COPPICE_CHECK(move_into(raw.positions, read_positions(model, position_accessor)));
  const std::size_t count = raw.positions.size();
  const std::uint32_t material = primitive.material < 0 ? kNone : static_cast<std::uint32_t>(primitive.material);
  const TextureUvs texture = texture_uvs(model, material);
  COPPICE_CHECK(move_into(raw.normals, read_attribute(model, primitive, "NORMAL", count, read_vectors<glm::vec3>)));
  COPPICE_CHECK(
      move_into(raw.uvs, read_attribute(model, primitive, "TEXCOORD_" + std::to_string(texture.set), count, read_vectors<glm::vec2>)));
  if (placed.wind_color_set != 0u) COPPICE_CHECK(move_into(raw.colors, read_attribute(model, primitive, "COLOR_0", count, read_colors)));
  for (glm::vec4& color : raw.colors)
    for (int c = 0; c < 4; ++c)
      if (!(color[c] >= 0.0f && color[c] <= 1.0f)) color[c] = 1.0f;  // also for NaN
  if (texture.is_transformed)
    for (glm::vec2& uv : raw.uvs) uv = glm::vec2(texture.offset + texture.linear * glm::dvec2(uv));
  COPPICE_TRY(order, read_vertex_order(model, primitive.indices, count));
  raw.triangles = triangulate(primitive.mode, order);
  drop_repeated_triangles(raw);
  return raw;
}

/// Area-weighted sums of the normals of the triangles round each vertex.
std::vector<glm::vec3> summed_normals(const RawPrimitive& raw) {
  std::vector<glm::vec3> normals(raw.positions.size(), glm::vec3(0.0f));
  for (std::size_t i = 0; i < raw.triangles.size(); i += 3) {
    const auto& [a, b, c] = at_corners(raw.positions, raw.triangles, i);
    const glm::vec3 normal = glm::cross(b - a, c - a);
    for (std::size_t k = 0; k < 3; ++k) normals[raw.triangles[i + k]] += normal;
  }
  return normals;
}

/// A unit vector along v; the fallback if v has no direction.
glm::vec3 unit_or(const glm::dvec3& v, const glm::vec3& fallback) {
  const double length = glm::length(v);
  return std::isfinite(length) && length > 0.0 ? glm::vec3(v / length) : fallback;
}

/// A round place near points that lie so far off the origin that floats would round them; (0, 0, 0) for others.
glm::dvec3 anchor_of(const std::vector<glm::dvec3>& points) {
  constexpr double kFarSizes = 64.0, kFar_m = 100.0;
  const auto box = box_of(points);
  const glm::dvec3 middle = 0.5 * (box.low + box.high);
  const double far_m = std::max(kFar_m, kFarSizes * glm::length(box.extent()));
  return glm::length(middle) > far_m ? glm::round(middle) : glm::dvec3(0.0);
}

Result<void> append_positions(const RawPrimitive& raw, const MeshInstance& instance, TriangleSoup& soup) {
  std::vector<glm::dvec3> all;
  all.reserve(raw.positions.size());
  for (const glm::vec3& position : raw.positions) {
    const glm::dvec3& placed = all.emplace_back(instance.scene_from_mesh * glm::dvec4(position, 1.0));
    // Written so that NaN fails too.
    if (!(std::abs(placed.x) <= kMaxCoordinate_m && std::abs(placed.y) <= kMaxCoordinate_m && std::abs(placed.z) <= kMaxCoordinate_m))
      return Error{Status::bad_file, "position beyond 1e8 m", Error::kNoOffset, "nodes[" + std::to_string(instance.node) + "].mesh"};
  }
  if (soup.mesh.positions.empty() && !all.empty()) soup.anchor = anchor_of(all);
  for (const glm::dvec3& placed : all) soup.mesh.positions.push_back(glm::vec3(placed - soup.anchor));
  return {};
}

void append_normals(const RawPrimitive& raw, const glm::dmat3& scene_from_mesh, bool mirrored, Mesh& mesh) {
  // The cofactors are the inverse transpose times the determinant. They exist even if the inverse does not.
  glm::dmat3 scene_from_normal(glm::cross(scene_from_mesh[1], scene_from_mesh[2]), glm::cross(scene_from_mesh[2], scene_from_mesh[0]),
                               glm::cross(scene_from_mesh[0], scene_from_mesh[1]));
  if (mirrored) scene_from_normal = -scene_from_normal;
  const std::vector<glm::vec3> computed = summed_normals(raw);
  constexpr glm::vec3 kUp(0.0f, 1.0f, 0.0f);
  for (std::size_t i = 0; i < raw.positions.size(); ++i) {
    const bool usable = !raw.normals.empty() && is_finite(raw.normals[i]) && raw.normals[i] != glm::vec3(0.0f);
    const glm::dvec3 normal(unit_or(usable ? raw.normals[i] : computed[i], kUp));
    mesh.normals.push_back(unit_or(scene_from_normal * normal, kUp));
  }
}

void append_uvs(const RawPrimitive& raw, const std::string& place, Mesh& mesh, std::vector<std::string>& warnings) {
  std::size_t repaired_count = 0;
  for (std::size_t i = 0; i < raw.positions.size(); ++i) {
    const glm::vec2 uv = raw.uvs.empty() ? glm::vec2(0.0f) : raw.uvs[i];
    if (!is_finite(uv)) ++repaired_count;
    mesh.uvs.push_back(is_finite(uv) ? uv : glm::vec2(0.0f));
  }
  if (repaired_count > 0) warnings.push_back(place + ": " + std::to_string(repaired_count) + " texture coordinates not finite, read as 0");
}

/// Appends values of the last `vertex_count` vertices of all. Vertices of primitives that have none get `missing`, if any has some.
template <class Value>
void append_values(const std::vector<Value>& values, std::size_t vertex_count, std::size_t all_count, const Value& missing,
                   std::vector<Value>& all) {
  if (values.empty() && all.empty()) return;
  all.resize(all_count - vertex_count, missing);
  all.insert(all.end(), values.begin(), values.end());
  all.resize(all_count, missing);
}

}  // namespace

Result<void> append_primitive(const tinygltf::Model& model, const PlacedPrimitive& placed, TriangleSoup& soup,
                              std::vector<std::string>& warnings) {
  const MeshInstance& instance = placed.instance;
  const tinygltf::Primitive& primitive = model.meshes.at(instance.mesh).primitives.at(placed.primitive_index);
  if (primitive.mode < TINYGLTF_MODE_TRIANGLES) return {};
  const std::string place = primitive_place(instance.mesh, placed.primitive_index);
  Mesh& mesh = soup.mesh;
  Result<RawPrimitive> raw = read_primitive(model, primitive, placed);
  if (!raw) return at_place(place, raw.error());
  const glm::dmat3 linear(instance.scene_from_mesh);
  const bool mirrored = glm::determinant(linear) < 0.0;
  const auto first_vertex = static_cast<std::uint32_t>(mesh.positions.size());
  COPPICE_CHECK(append_positions(*raw, instance, soup));
  append_normals(*raw, linear, mirrored, mesh);
  append_uvs(*raw, place, mesh, warnings);
  soup.vertex_instances.resize(mesh.positions.size(), placed.instance_index);
  for (std::size_t i = 0; i < raw->triangles.size(); i += 3) {
    const std::uint32_t a = raw->triangles[i], b = raw->triangles[i + 1], c = raw->triangles[i + 2];
    for (const std::uint32_t corner : {a, mirrored ? c : b, mirrored ? b : c}) mesh.indices.push_back(first_vertex + corner);
    mesh.triangle_materials.push_back(placed.material);
  }
  const std::size_t vertex_count = raw->positions.size(), all_count = mesh.positions.size();
  append_values(raw->colors, vertex_count, all_count, glm::vec4(1.0f), soup.vertex_colors);
  // Elsewhere the alpha of colours means what anybody wants; beside _SPREAD it is opacity.
  const std::vector<float> alongs = read_alongs(model, primitive, vertex_count, place, warnings);
  append_values(alongs, vertex_count, all_count, 1.0f, mesh.vertex_alongs);
  std::vector<std::uint8_t> opacities;
  if (!alongs.empty())
    for (const glm::vec4& color : raw->colors)
      opacities.push_back(static_cast<std::uint8_t>(std::max(1L, std::lround(color.a * float{kOpaque}))));
  append_values(opacities, vertex_count, all_count, kOpaque, mesh.vertex_opacities);
  append_values(read_wind_weights(model, primitive, placed, place, warnings), vertex_count, all_count, kNoWeight, mesh.wind_weights);
  if (!raw->colors.empty() && names_wind(model.meshes.at(instance.mesh).name)) soup.wind_materials.insert(placed.material);
  return {};
}

}  // namespace coppice::bake
