#include "gltf_lines.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string_view>
#include <utility>

#include <tiny_gltf.h>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "gltf_accessor.h"
#include "text_number.h"
#include "weld.h"

namespace coppice::bake {
namespace {

// A spruce's needle is about this many times as long as wide; those of pines are narrower, but a model has fewer of them than a tree. Lines
// of several segments are blades of grass or twigs.
constexpr double kNeedleLengths = 20.0, kBladeLengths = 40.0, kMinLengths = 4.0;
// Cosine of the angle by which a line may turn from one segment to the next.
constexpr double kMinTurnCosine = 0.5;
// Those that the importer reads, but for normals: strips have normals of their own.
constexpr std::array<std::string_view, 8> kCarried{"TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2", "TEXCOORD_3",
                                                   "COLOR_0",    "COLOR_1",    "_WIND",      "_WIND_WEIGHT"};

using Segment = std::array<std::uint32_t, 2>;  ///< vertices
using Line = std::vector<std::uint32_t>;       ///< vertices from end to end

bool is_line(const tinygltf::Primitive& primitive) {
  return primitive.mode > TINYGLTF_MODE_POINTS && primitive.mode < TINYGLTF_MODE_TRIANGLES && primitive.attributes.count("POSITION") > 0;
}

std::vector<Segment> segments_of(int mode, const std::vector<std::uint32_t>& order) {
  std::vector<Segment> segments;
  for (std::size_t i = 0; i + 1 < order.size(); i += mode == TINYGLTF_MODE_LINE ? 2 : 1) segments.push_back({order[i], order[i + 1]});
  if (mode == TINYGLTF_MODE_LINE_LOOP && order.size() > 2) segments.push_back({order.back(), order.front()});
  return segments;
}

/// Joins segments to lines. End k of segment i has the number 2 i + k.
class LineFinder {
 public:
  LineFinder(const std::vector<glm::vec3>& positions, std::vector<Segment> segments)
      : positions_(positions), segments_(std::move(segments)), welded_(weld(positions, std::vector<std::uint32_t>(positions.size(), 0))) {
    std::erase_if(segments_, [this](const Segment& each) { return welded_[each[0]] == welded_[each[1]]; });
    is_taken_.assign(segments_.size(), false);
    join_ends();
  }

  std::vector<Line> find() {
    std::vector<Line> lines;
    for (const bool closed : {false, true})  // rings are what is left then
      for (std::uint32_t end = 0; end < joined_.size(); ++end)
        if (!is_taken_[end / 2] && (closed || joined_[end] == kNone)) lines.push_back(follow(end));
    return lines;
  }

 private:
  [[nodiscard]] std::uint32_t vertex(std::uint32_t end) const { return segments_[end / 2][end % 2]; }
  /// From this end to the other one of its segment.
  [[nodiscard]] glm::dvec3 direction(std::uint32_t end) const {
    return glm::normalize(glm::dvec3(positions_[vertex(end ^ 1u)]) - glm::dvec3(positions_[vertex(end)]));
  }

  void join_ends() {
    struct Meeting {
      std::array<std::uint32_t, 2> ends{};
      std::uint32_t count = 0;
    };
    std::vector<Meeting> meetings(positions_.size());
    joined_.assign(2 * segments_.size(), kNone);
    for (std::uint32_t end = 0; end < joined_.size(); ++end)
      if (Meeting& at = meetings[welded_[vertex(end)]]; at.count++ < 2) at.ends[at.count - 1] = end;
    for (const auto& [ends, count] : meetings) {
      if (count != 2 || glm::dot(-direction(ends[0]), direction(ends[1])) < kMinTurnCosine) continue;
      joined_[ends[0]] = ends[1];
      joined_[ends[1]] = ends[0];
    }
  }

  Line follow(std::uint32_t end) {
    Line line{vertex(end)};
    for (; end != kNone && !is_taken_[end / 2]; end = joined_[end ^ 1u]) {
      is_taken_[end / 2] = true;
      line.push_back(vertex(end ^ 1u));
    }
    return line;
  }

  const std::vector<glm::vec3>& positions_;
  std::vector<Segment> segments_;
  std::vector<std::uint32_t> welded_;
  std::vector<std::uint32_t> joined_;  ///< [end] the end that goes on from here, kNone at the end of a line
  std::vector<bool> is_taken_;         ///< [segment]
};

double length_of(const std::vector<glm::vec3>& positions, const Line& line) {
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) length += glm::distance(glm::dvec3(positions[line[i]]), glm::dvec3(positions[line[i - 1]]));
  return length;
}

struct Strips {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> sources;    ///< [positions] the vertex beside which each stands
  std::vector<std::uint32_t> triangles;  ///< 3 vertices each
};

glm::dvec3 any_across(const glm::dvec3& along) {
  return glm::normalize(glm::cross(along, std::abs(along.y) < 0.9 ? glm::dvec3(0.0, 1.0, 0.0) : glm::dvec3(1.0, 0.0, 0.0)));
}

/// Appends a strip about a line; `angle_rad` turns it about its first segment.
void append_strip(const std::vector<glm::vec3>& positions, const Line& line, double width, double angle_rad, Strips& strips) {
  const auto at = [&](std::size_t i) { return glm::dvec3(positions[line[i]]); };
  glm::dvec3 across = any_across(glm::normalize(at(1) - at(0)));
  across = std::cos(angle_rad) * across + std::sin(angle_rad) * glm::cross(glm::normalize(at(1) - at(0)), across);
  for (std::size_t i = 0; i < line.size(); ++i) {
    const glm::dvec3 along = glm::normalize(at(std::min(i + 1, line.size() - 1)) - at(i == 0 ? 0 : i - 1));
    across -= glm::dot(across, along) * along;
    across = glm::length(across) > 1e-3 ? glm::normalize(across) : any_across(along);
    const auto left = static_cast<std::uint32_t>(strips.positions.size());
    for (const double side : {-0.5, 0.5}) {
      strips.positions.emplace_back(at(i) + side * width * across);
      strips.sources.push_back(line[i]);
    }
    if (i > 0) strips.triangles.insert(strips.triangles.end(), {left - 2, left - 1, left + 1, left - 2, left + 1, left});
  }
}

Result<WidenedLines> widen(tinygltf::Model& model, tinygltf::Primitive& primitive) {
  const int position_accessor = primitive.attributes.at("POSITION");
  COPPICE_TRY(positions, read_positions(model, position_accessor));
  COPPICE_TRY(order, read_vertex_order(model, primitive.indices, positions.size()));
  const std::vector<Line> lines = LineFinder(positions, segments_of(primitive.mode, order)).find();
  primitive.targets.clear();
  primitive.mode = TINYGLTF_MODE_POINTS;
  if (lines.empty()) return WidenedLines{};

  std::vector<double> lengths;
  for (const Line& line : lines) lengths.push_back(length_of(positions, line));
  std::vector<double> sorted = lengths;
  std::ranges::nth_element(sorted, sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2));
  WidenedLines widened;
  widened.count = static_cast<std::uint32_t>(lines.size());
  const auto is_needle = [](const Line& line) { return line.size() == 2; };
  const bool are_needles = 2 * static_cast<std::size_t>(std::ranges::count_if(lines, is_needle)) >= lines.size();
  widened.width = sorted[sorted.size() / 2] / (are_needles ? kNeedleLengths : kBladeLengths);
  Strips strips;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    // Steps of the golden ratio are spread evenly, however many there are.
    const double turn = std::fmod(static_cast<double>(i) * (std::numbers::phi - 1.0), 1.0);
    append_strip(positions, lines[i], std::min(widened.width, lengths[i] / kMinLengths), std::numbers::pi * turn, strips);
  }

  std::map<std::string, int> attributes{{"POSITION", add_vec3(model, strips.positions)}};
  for (const auto& [name, accessor] : primitive.attributes) {
    if (std::ranges::find(kCarried, name) == kCarried.end()) continue;
    if (model.accessors.at(static_cast<std::size_t>(accessor)).count != positions.size())
      return Error{Status::bad_file, "attributes of unequal length", Error::kNoOffset, name + " and POSITION"};
    COPPICE_CHECK(move_into(attributes[name], add_copy_of_elements(model, accessor, strips.sources)));
  }
  primitive.attributes = std::move(attributes);
  primitive.indices = add_uint32(model, strips.triangles);
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  return widened;
}

}  // namespace

Result<std::vector<WidenedLines>> widen_lines(tinygltf::Model& model) {
  std::vector<WidenedLines> widened;
  for (std::size_t m = 0; m < model.meshes.size(); ++m)
    for (std::size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      tinygltf::Primitive& primitive = model.meshes[m].primitives[p];
      if (!is_line(primitive)) continue;
      Result<WidenedLines> of = widen(model, primitive);
      if (!of) return at_place(primitive_place(m, p), of.error());
      of->mesh = static_cast<std::uint32_t>(m);
      if (of->count > 0) widened.push_back(*of);
    }
  return widened;
}

std::string lines_text(const std::vector<WidenedLines>& lines, const std::vector<MeshInstance>& instances) {
  std::uint64_t count = 0;
  double narrowest_m = std::numeric_limits<double>::max(), widest_m = 0.0;
  if (lines.empty()) return {};
  for (const MeshInstance& instance : instances)
    for (auto each = std::ranges::lower_bound(lines, instance.mesh, {}, &WidenedLines::mesh);
         each != lines.end() && each->mesh == instance.mesh; ++each) {
      const double width_m = each->width * std::cbrt(std::abs(glm::determinant(glm::dmat3(instance.scene_from_mesh))));
      count += each->count;
      narrowest_m = std::min(narrowest_m, width_m);
      widest_m = std::max(widest_m, width_m);
    }
  if (count == 0) return {};
  std::string widths = formatted("%.2g", 1e3 * narrowest_m);
  if (const std::string widest = formatted("%.2g", 1e3 * widest_m); widest != widths) widths += " to " + widest;
  return std::to_string(count) + " lines became strips " + widths + " mm wide";
}

}  // namespace coppice::bake
