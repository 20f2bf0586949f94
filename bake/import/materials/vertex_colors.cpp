#include "vertex_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include <glm/common.hpp>

#include "node_names.h"
#include "texture_shown.h"
#include "union_find.h"
#include "weld.h"

namespace coppice::bake {
namespace {

/// A difference that a person would call another colour.
constexpr float kVisibleDifference = 0.1f;
/// A channel that varies less is constant. One that stays this near to 0 or 1 says nothing.
constexpr double kConstant = 0.02;
/// Minimum range of a weight, and of a phase.
constexpr double kMinRange = 0.3, kMinPhaseRange = 0.5;
/// Minimum correlation with height of a weight that grows with it, and maximum correlation of channels that have nothing to do with each
/// other.
constexpr double kGrows = 0.9, kApart = 0.5;
/// How many pieces it takes to judge how a channel varies within one, the share of them that must agree, and the share of the whole range
/// that each has.
constexpr std::size_t kMinPieces = 8;
constexpr double kMaxPieces = 0.8, kWholeRange = 0.8;

struct Range {
  double low = 1.0, high = 0.0;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] double size() const { return std::max(high - low, 0.0); }
};

double correlation(std::span<const ColoredVertex> vertices, const auto& x_of, const auto& y_of) {
  double x_sum = 0.0, y_sum = 0.0;
  for (const ColoredVertex& vertex : vertices) {
    x_sum += x_of(vertex);
    y_sum += y_of(vertex);
  }
  const double count = static_cast<double>(vertices.size()), x_mean = x_sum / count, y_mean = y_sum / count;
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (const ColoredVertex& vertex : vertices) {
    const double x = x_of(vertex) - x_mean, y = y_of(vertex) - y_mean;
    xx += x * x;
    yy += y * y;
    xy += x * y;
  }
  return xx > 0.0 && yy > 0.0 ? xy / std::sqrt(xx * yy) : 0.0;
}

/// How one channel varies.
struct Channel {
  Range range;
  double with_height = 0.0;      ///< correlation
  double whole_pieces = 0.0;     ///< share of pieces in which it has nearly its whole range
  double constant_pieces = 0.0;  ///< share of pieces in which it is constant
  std::size_t piece_count = 0;   ///< how many have at least three vertices

  [[nodiscard]] bool is_constant() const { return range.size() < kConstant; }
  [[nodiscard]] bool is_at_end() const { return is_constant() && (range.high < kConstant || range.low > 1.0 - kConstant); }
  [[nodiscard]] bool grows() const {
    return range.size() >= kMinRange && (std::abs(with_height) >= kGrows || (piece_count >= kMinPieces && whole_pieces >= kMaxPieces));
  }
  [[nodiscard]] bool is_phase() const {
    return range.size() >= kMinPhaseRange && piece_count >= kMinPieces && constant_pieces >= kMaxPieces && std::abs(with_height) < kApart;
  }
};

Channel measure(std::span<const ColoredVertex> vertices, int c) {
  Channel channel;
  std::map<std::uint32_t, std::pair<Range, std::size_t>> pieces;
  for (const ColoredVertex& vertex : vertices) {
    channel.range.add(vertex.color[c]);
    auto& [range, count] = pieces[vertex.piece];
    range.add(vertex.color[c]);
    ++count;
  }
  channel.with_height = correlation(
      vertices, [](const ColoredVertex& v) { return static_cast<double>(v.position.y); },
      [c](const ColoredVertex& v) { return static_cast<double>(v.color[c]); });
  std::size_t whole = 0, constant = 0;
  for (const auto& [piece, of_piece] : pieces) {
    if (of_piece.second < 3) continue;
    ++channel.piece_count;
    if (of_piece.first.size() >= kWholeRange * channel.range.size()) ++whole;
    if (of_piece.first.size() < kConstant) ++constant;
  }
  if (channel.piece_count == 0) return channel;
  channel.whole_pieces = static_cast<double>(whole) / static_cast<double>(channel.piece_count);
  channel.constant_pieces = static_cast<double>(constant) / static_cast<double>(channel.piece_count);
  return channel;
}

bool is_grey(std::span<const ColoredVertex> vertices) {
  return std::ranges::all_of(vertices, [](const ColoredVertex& v) {
    return std::abs(v.color.r - v.color.g) < static_cast<float>(kConstant) &&
           std::abs(v.color.r - v.color.b) < static_cast<float>(kConstant);
  });
}

/// [material] the vertices of its triangles.
std::vector<std::vector<ColoredVertex>> vertices_by_material(const TriangleSoup& soup, std::size_t material_count) {
  const Mesh& mesh = soup.mesh;
  const std::vector<std::uint32_t> welded = weld(mesh.positions, soup.vertex_instances);
  UnionFind sets(welded.size());
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
    for (std::size_t k = 1; k < 3; ++k) sets.join(welded[mesh.indices[i]], welded[mesh.indices[i + k]]);
  std::vector<std::vector<ColoredVertex>> vertices(material_count);
  std::vector<bool> taken(mesh.positions.size(), false);
  for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
    const std::uint32_t vertex = mesh.indices[i];
    if (taken[vertex]) continue;
    taken[vertex] = true;
    vertices[mesh.triangle_materials[i / 3]].push_back(
        {mesh.positions[vertex], glm::vec3(soup.vertex_colors[vertex]), sets.find(welded[vertex])});
  }
  return vertices;
}

/// How the vertex colours of a material differ.
struct Spread {
  glm::vec4 smallest{1.0f}, largest{0.0f};
  ColorSum sum;
};

glm::dvec3 triangle_tint(const TriangleSoup& soup, std::size_t triangle) {
  glm::dvec3 tint(0.0);
  for (std::size_t k = 0; k < 3; ++k) tint += glm::dvec3(soup.vertex_colors[soup.mesh.indices[3 * triangle + k]]) / 3.0;
  return tint;
}

std::vector<Spread> spreads_by_material(const TriangleSoup& soup, std::size_t material_count) {
  std::vector<Spread> spreads(material_count);
  for (std::size_t t = 0; t < soup.mesh.triangle_materials.size(); ++t) {
    Spread& spread = spreads[soup.mesh.triangle_materials[t]];
    const double area_m2 = triangle_area_m2(soup.mesh, t);
    spread.sum.add({area_m2 * triangle_tint(soup, t), area_m2});
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec4& color = soup.vertex_colors[soup.mesh.indices[3 * t + k]];
      spread.smallest = glm::min(spread.smallest, color);
      spread.largest = glm::max(spread.largest, color);
    }
  }
  return spreads;
}

void warn(const std::string& material, const Spread& of, bool is_wind, std::vector<std::string>& warnings) {
  const glm::vec4 spread = of.largest - of.smallest;
  const std::string name = "material '" + material.substr(0, 64) + "': ";
  if (is_wind) {
    warnings.push_back(name + "its vertex colours look like wind weights and are not used as colours");
    return;
  }
  if (std::max({spread.r, spread.g, spread.b}) > kVisibleDifference)
    warnings.push_back(
        name + "its vertex colours differ; leaves and pieces of wood that differ clearly become separate materials, each with its mean");
  if (std::max({of.largest.r, of.largest.g, of.largest.b}) < static_cast<float>(kConstant))
    warnings.push_back(name + "its vertex colours, COLOR_0, are black, and so is what they tint; without them it has its own colour");
  if (spread.a > kVisibleDifference) warnings.push_back(name + "the alpha of its vertex colours is not used");
}

}  // namespace

bool looks_like_wind(std::span<const ColoredVertex> vertices) {
  if (vertices.size() < 3) return false;
  const std::array<Channel, 3> channels{measure(vertices, 0), measure(vertices, 1), measure(vertices, 2)};
  if (is_grey(vertices)) return channels[0].grows() && channels[0].range.low < kConstant && channels[0].range.high > 1.0 - kConstant;
  for (int c = 0; c < 3; ++c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    if (!channel.grows() && !channel.is_phase()) continue;
    bool alone = true;
    for (int other = 0; other < 3 && alone; ++other) {
      const Channel& beside = channels[static_cast<std::size_t>(other)];
      if (other == c || beside.is_at_end()) continue;
      const double together = correlation(
          vertices, [c](const ColoredVertex& v) { return static_cast<double>(v.color[c]); },
          [other](const ColoredVertex& v) { return static_cast<double>(v.color[other]); });
      alone = !beside.is_constant() && std::abs(together) < kApart;
    }
    if (alone) return true;
  }
  return false;
}

void apply_vertex_colors(TriangleSoup& soup, std::vector<Material>& materials, std::vector<std::string>& warnings) {
  if (soup.vertex_colors.empty()) return;
  const std::vector<Spread> spreads = spreads_by_material(soup, materials.size());
  const std::vector<std::vector<ColoredVertex>> vertices = vertices_by_material(soup, materials.size());
  std::vector<glm::dvec3> means(materials.size(), glm::dvec3(1.0));
  std::vector<bool> is_wind(materials.size(), false);
  for (std::size_t m = 0; m < materials.size(); ++m) {
    if (!(spreads[m].sum.area_m2 > 0.0)) continue;
    const glm::vec4 spread = spreads[m].largest - spreads[m].smallest;
    const bool differ = std::max({spread.r, spread.g, spread.b}) > kVisibleDifference;
    is_wind[m] = differ && (soup.wind_materials.count(static_cast<std::uint32_t>(m)) > 0 || names_wind(materials[m].name) ||
                            looks_like_wind(vertices[m]));
    warn(materials[m].name, spreads[m], is_wind[m], warnings);
    if (is_wind[m]) continue;
    means[m] = spreads[m].sum.mean();
    for (int c = 0; c < 3; ++c) materials[m].base_color[c] *= static_cast<float>(means[m][c]);
  }
  Mesh& mesh = soup.mesh;
  for (std::size_t t = 0; t < mesh.triangle_materials.size(); ++t) {
    const std::uint32_t material = mesh.triangle_materials[t];
    glm::vec3 tint(1.0f);
    for (int c = 0; c < 3 && !is_wind[material]; ++c)
      if (means[material][c] > 0.0) tint[c] = static_cast<float>(triangle_tint(soup, t)[c] / means[material][c]);
    mesh.triangle_tints.push_back(tint);
  }
  soup.vertex_colors.clear();
}

}  // namespace coppice::bake
