#include "wood_shells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace coppice::gpu {
namespace {

using Vector = std::array<double, 3>;

/// For each vertex the first one in its place: seams of texture coordinates and normals split vertices, not surfaces.
std::vector<std::uint32_t> places(const WoodMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size()), place(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto position = [&](std::uint32_t i) -> const std::array<float, 3>& { return mesh.vertices[i].position; };
  std::ranges::sort(order, [&](auto a, auto b) { return position(a) != position(b) ? position(a) < position(b) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i)
    place[order[i]] = i > 0 && position(order[i]) == position(order[i - 1]) ? place[order[i - 1]] : order[i];
  return place;
}

std::uint32_t root_of(std::vector<std::uint32_t>& parents, std::uint32_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

/// Twice its area, along its face.
Vector face_of(const WoodMesh& mesh, std::size_t triangle) {
  std::array<Vector, 2> edges{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = [&](std::size_t corner) {
      return static_cast<double>(mesh.vertices[mesh.indices[3 * triangle + corner]].position[axis]);
    };
    edges[0][axis] = at(1) - at(0);
    edges[1][axis] = at(2) - at(0);
  }
  const auto& [a, b] = edges;
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double length(const Vector& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

int side_of(const WoodMesh& mesh, std::size_t triangle, const Vector& face) {
  double along = 0;
  for (std::size_t corner = 0; corner < 3; ++corner)
    for (std::size_t axis = 0; axis < 3; ++axis)
      along += face[axis] * static_cast<double>(mesh.vertices[mesh.indices[3 * triangle + corner]].normal[axis]);
  return along > 0 ? 1 : along < 0 ? -1 : 0;
}

}  // namespace

std::vector<int> outward_sides(const WoodMesh& mesh) {
  std::vector<std::uint32_t> parents = places(mesh);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t one = root_of(parents, mesh.indices[i - i % 3]), other = root_of(parents, mesh.indices[i]);
    parents[std::max(one, other)] = std::min(one, other);
  }
  struct Surface {
    Vector facing{};  // the sum of its triangles', all turned outwards
    double area = 0;
  };
  std::vector<Surface> surfaces(mesh.vertices.size());
  std::vector<int> sides;
  for (std::size_t triangle = 0; 3 * triangle < mesh.indices.size(); ++triangle) {
    const Vector face = face_of(mesh, triangle);
    sides.push_back(side_of(mesh, triangle, face));
    Surface& surface = surfaces[root_of(parents, mesh.indices[3 * triangle])];
    for (std::size_t axis = 0; axis < 3; ++axis) surface.facing[axis] += sides.back() * face[axis];
    surface.area += length(face);
  }
  // An open end of a tube is a small part of it; half a ball faces its rim by half.
  constexpr double kClosed = 0.3;
  for (std::size_t triangle = 0; triangle < sides.size(); ++triangle) {
    const Surface& surface = surfaces[root_of(parents, mesh.indices[3 * triangle])];
    if (!(length(surface.facing) < kClosed * surface.area)) sides[triangle] = 0;
  }
  return sides;
}

}  // namespace coppice::gpu
