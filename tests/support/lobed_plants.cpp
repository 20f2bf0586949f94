#include "lobed_plants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "seeded_random.h"

namespace coppice::bake::test {
namespace {

struct Piece {
  std::vector<glm::vec3> points;
  std::vector<glm::vec2> uvs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::uint32_t material = 0, owner = 0, number = 0;  ///< owner: pieces of one share vertices, if they are to; number: within the owner
};

struct Outline {
  std::vector<glm::dvec3> points;  ///< x along the leaf, y across it
  std::vector<glm::dvec2> uvs;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// A lobe along x from the origin; point 0 is at the stalk, 1 left, 2 right, 4 the tip.
Outline lobe_outline(LobeShape shape, double length, double width, double skew) {
  Outline lobe;
  if (shape == LobeShape::pyramid) {
    lobe.points = {{0.0, 0.0, 0.0}, {0.45, 0.5, 0.0}, {0.5 + skew, -0.5, 0.0}, {0.5, 0.0, 0.15}, {1.0, 0.0, 0.0}};
    lobe.triangles = {{0, 2, 1}, {1, 2, 4}, {0, 3, 2}, {2, 3, 4}, {4, 3, 1}, {1, 3, 0}};
  } else {
    lobe.points = {{0.0, 0.0, 0.0}, {0.3, 0.5, 0.0}, {0.4 + skew, -0.5, 0.0}, {0.75, 0.3, 0.0}, {1.0, 0.0, 0.0}};
    lobe.triangles = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4}};
  }
  if (shape == LobeShape::unlike) {
    lobe.points.emplace_back(0.8, -0.3, 0.0);
    lobe.triangles.push_back({2, 4, 5});
  }
  for (glm::dvec3& point : lobe.points) {
    lobe.uvs.emplace_back(point.x, point.y);
    point *= glm::dvec3(length, width, length);
  }
  return lobe;
}

/// The lobes of a leaf of length 1 whose stalk is the origin.
std::vector<Outline> leaf_outlines(const LobedPlant& plant) {
  std::vector<Outline> lobes;
  const double middle = 0.5 * (plant.lobe_count - 1.0);
  const bool is_row = plant.form == LobeForm::equal && plant.contact != LobeContact::stalk;
  for (std::uint32_t k = 0; k < plant.lobe_count; ++k) {
    const double side = k - middle, beside = plant.form == LobeForm::equal ? 0.0 : std::abs(side);
    const bool is_plain = plant.shape == LobeShape::unlike && std::abs(side) > 0.6;
    Outline lobe = lobe_outline(is_plain ? LobeShape::strip : plant.shape, 1.0 - 0.17 * beside, 0.3 + 0.06 * beside,
                                plant.form == LobeForm::own ? 0.08 * k : 0.0);
    const double direction = is_row ? 0.0 : -plant.step * side;
    for (glm::dvec3& point : lobe.points) {
      if (plant.form == LobeForm::mirrored && side > 0.0) point.y = -point.y;
      const glm::dvec3 raised(std::cos(plant.cone) * point.x, point.y, point.z + std::sin(plant.cone) * point.x);
      point = {std::cos(direction) * raised.x - std::sin(direction) * raised.y,
               std::sin(direction) * raised.x + std::cos(direction) * raised.y, raised.z};
    }
    auto& points = lobe.points;
    if (k > 0 && plant.contact == LobeContact::corner) {
      const glm::dvec3 shift = lobes.back().points[2] - points[1];
      for (glm::dvec3& point : points) point += shift;
    }
    if (k > 0 && plant.contact == LobeContact::two_points) points[3] = lobes.back().points[2];
    if (k > 0 && plant.contact == LobeContact::edge) points[1] = lobes.back().points[2];
    for (std::size_t i = 0; i < points.size() && !plant.are_leaves; ++i) lobe.uvs[i] = points[i];
    lobes.push_back(std::move(lobe));
  }
  return lobes;
}

class LobeGrower {
 public:
  explicit LobeGrower(const LobedPlant& plant) : plant_(plant), random_(plant.seed) {}

  GrownPlant grow() {
    const std::uint32_t leaves_a_twig = 6;
    for (std::uint32_t i = 0; i < plant_.leaf_count; ++i) {
      if (i % leaves_a_twig == 0) start_twig();
      add_leaf(i, i % leaves_a_twig);
    }
    order_pieces();
    add_tube(1, 0.0, 3.0, 0.08, 0.05, 8);  // the trunk
    add_pot();
    GrownPlant grown;
    for (const char* name : {"Leaves", "Trunk", "Material"}) {
      Material material;
      material.name = plant_.has_names ? name : "";
      material.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1.0f);
      grown.materials.push_back(material);
    }
    emit(grown.soup);
    return grown;
  }

 private:
  static double between(double low, double high, SeededRandom& random) { return low + (high - low) * random.uniform(); }

  static glm::dvec3 direction(SeededRandom& random) {
    const double y = between(-1.0, 1.0, random), turn = between(0.0, 2.0 * std::numbers::pi, random), r = std::sqrt(1.0 - y * y);
    return {r * std::cos(turn), y, r * std::sin(turn)};
  }

  static glm::dmat3 rotation(SeededRandom& random) {
    const glm::dvec3 x = direction(random), z = glm::normalize(glm::cross(x, direction(random)));
    return {x, glm::cross(z, x), z};
  }

  glm::vec3 rounded(const glm::dvec3& point) const {
    return plant_.step_m > 0.0 ? glm::vec3(glm::round(point / plant_.step_m) * plant_.step_m) : glm::vec3(point);
  }

  /// A new twig in the crown: where its six leaves are, and its pieces if it has any.
  void start_twig() {
    ++owner_;
    leaf_random_ = SeededRandom(plant_.instanced_twigs ? 7 : random_.next());
    const glm::dvec3 from = glm::dvec3(0.0, 3.5, 0.0) + 1.5 * std::cbrt(random_.uniform()) * direction(random_);
    const glm::dmat3 turn = rotation(random_);
    twig_turn_ = turn;
    joints_.clear();
    for (int i = 0; i < 6; ++i) joints_.push_back(from + turn * glm::dvec3(0.08 * i, 0.012 * (i % 2), 0.008 * (i % 3)));
    for (std::uint32_t i = 0; i < 5 && plant_.twigs != TwigForm::none; ++i) add_segment(i, turn);
  }

  void add_segment(std::uint32_t i, const glm::dmat3& turn) {
    const glm::dvec3 a = joints_[i], b = joints_[i + 1], y = 0.004 * turn[1], z = 0.004 * turn[2];
    Piece piece;
    if (plant_.twigs == TwigForm::prisms) {
      for (const glm::dvec3& point :
           {a, glm::mix(a, b, 0.5) + y + z, glm::mix(a, b, 0.5) - y + z, glm::mix(a, b, 0.5) - y - z, glm::mix(a, b, 0.5) + y - z, b})
        piece.points.push_back(rounded(point));
      for (std::uint32_t k = 0; k < 4; ++k) {
        piece.triangles.push_back({0, 1 + k, 1 + (k + 1) % 4});
        piece.triangles.push_back({5, 1 + (k + 1) % 4, 1 + k});
      }
    } else {
      for (const glm::dvec3& point :
           {a, glm::mix(a, b, 0.2) + y, glm::mix(a, b, 0.4) - y, glm::mix(a, b, 0.6) + y, glm::mix(a, b, 0.8) - y, b})
        piece.points.push_back(rounded(point));
      for (std::uint32_t k = 0; k < 4; ++k) piece.triangles.push_back({k, k + 1, k + 2});
      for (std::uint32_t k = 0; k < 4; ++k) piece.triangles.push_back({k, k + 2, k + 1});
    }
    piece.uvs.assign(piece.points.size(), glm::vec2(0.0f));
    if (plant_.has_uvs)
      for (std::size_t k = 0; k < 6; ++k)
        piece.uvs[k] = {0.02f * static_cast<float>(i) + 0.004f * static_cast<float>(k), 0.9f + 0.01f * static_cast<float>(k % 2)};
    piece.owner = owner_;
    piece.number = i;
    pieces_.push_back(std::move(piece));
  }

  void add_leaf(std::uint32_t leaf, std::uint32_t joint) {
    ++owner_;
    SeededRandom& random = leaf_random_;
    const double size_m = between(0.07, 0.12, random), bend = plant_.bend * between(-1.0, 1.0, random);
    const glm::dmat3 turn = twig_turn_ * rotation(random);
    const glm::dvec3 gap = plant_.twigs_bear ? glm::dvec3(0.0) : twig_turn_ * (0.02 * direction(random));
    std::vector<Piece> lobes;
    for (const Outline& outline : leaf_outlines(plant_)) {
      Piece lobe;
      for (std::size_t i = 0; i < outline.points.size(); ++i) {
        const glm::dvec3& point = outline.points[i];
        const glm::dvec3 bent(point.x, point.y, point.z + 0.5 * bend * point.x * point.x);
        lobe.points.push_back(rounded(joints_[joint] + gap + size_m * (turn * bent)));
        lobe.uvs.push_back(plant_.has_uvs ? glm::vec2(0.1 + 0.4 * outline.uvs[i].x, 0.4 + 0.2 * outline.uvs[i].y) : glm::vec2(0.0f));
      }
      lobe.triangles = outline.triangles;
      lobe.owner = owner_;
      lobe.number = static_cast<std::uint32_t>(lobes.size());
      lobes.push_back(std::move(lobe));
    }
    if (leaf > 0 && random_.uniform() < plant_.touching) move_tip(lobes, tip_before_);
    tip_before_ = lobes[0].points[3];
    for (Piece& lobe : lobes) {
      add_degenerate(lobe);
      add_back(lobe);
      if (plant_.shuffled_triangles) shuffle(lobe.triangles);
      pieces_.push_back(std::move(lobe));
    }
  }

  /// Moves a leaf to where its last lobe ends in a point.
  static void move_tip(std::vector<Piece>& lobes, const glm::vec3& to) {
    const glm::vec3 from = lobes.back().points[4];
    for (Piece& lobe : lobes)
      for (glm::vec3& point : lobe.points) point = point == from ? to : point + (to - from);
  }

  /// Some lobes have one triangle without area, some two.
  void add_degenerate(Piece& lobe) {
    if (plant_.degenerate == Degenerate::collapsed || plant_.degenerate == Degenerate::both) {
      lobe.points.push_back(lobe.points[4]);
      lobe.uvs.push_back(lobe.uvs[4]);
      lobe.triangles.push_back({3, 4, 5});
      if (random_.below(3) == 0) lobe.triangles.push_back({2, 2, 2});
    }
    if (plant_.degenerate == Degenerate::slivers || plant_.degenerate == Degenerate::both) {
      const auto number = static_cast<std::uint32_t>(lobe.points.size());
      lobe.points.push_back(glm::mix(lobe.points[3], lobe.points[4], 0.5f));
      lobe.uvs.push_back(glm::mix(lobe.uvs[3], lobe.uvs[4], 0.5f));
      lobe.triangles.push_back({3, 4, number});
      if (random_.below(8) == 0) lobe.triangles.push_back({4, 3, number});
    }
  }

  void add_back(Piece& lobe) const {
    const auto triangles = lobe.triangles;
    auto shift = static_cast<std::uint32_t>(lobe.points.size());
    if (plant_.sides != LobeSides::both_with_own_vertices) shift = 0;
    for (const auto& [a, b, c] : triangles) {
      if (plant_.sides == LobeSides::repeated) lobe.triangles.push_back({a, b, c});
      if (plant_.sides == LobeSides::both || shift > 0) lobe.triangles.push_back({a + shift, c + shift, b + shift});
    }
    for (std::uint32_t i = 0; i < shift; ++i) {
      lobe.points.push_back(glm::vec3(lobe.points[i]));
      lobe.uvs.push_back(glm::vec2(lobe.uvs[i]));
    }
  }

  template <class T>
  void shuffle(std::vector<T>& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random_.below(static_cast<std::uint32_t>(i))]);
  }

  void order_pieces() {
    if (plant_.order == LobeOrder::by_lobe) std::ranges::stable_sort(pieces_, {}, &Piece::number);
    if (plant_.order == LobeOrder::shuffled) shuffle(pieces_);
  }

  /// One that is no lobe and no twig.
  void add_piece(Piece piece, std::uint32_t material) {
    piece.uvs.assign(piece.points.size(), glm::vec2(0.0f));
    piece.material = material;
    piece.owner = ++owner_;
    pieces_.push_back(std::move(piece));
  }

  /// An upright tube, open.
  void add_tube(std::uint32_t material, double low_m, double high_m, double radius_low_m, double radius_high_m, std::uint32_t sides) {
    Piece tube;
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double turn = 2.0 * std::numbers::pi * i / sides;
      tube.points.emplace_back(radius_low_m * std::cos(turn), low_m, radius_low_m * std::sin(turn));
      tube.points.emplace_back(radius_high_m * std::cos(turn), high_m, radius_high_m * std::sin(turn));
      tube.triangles.push_back({2 * i, 2 * i + 1, (2 * i + 2) % (2 * sides)});
      tube.triangles.push_back({2 * i + 1, (2 * i + 3) % (2 * sides), (2 * i + 2) % (2 * sides)});
    }
    add_piece(std::move(tube), material);
  }

  void add_pot() {
    constexpr std::uint32_t kSides = 24;
    if (plant_.pot == PotForm::none) return;
    add_tube(2, -0.3, 0.02, 0.2, 0.3, kSides);
    add_tube(2, -0.3, 0.02, 0.18, 0.28, kSides);
    Piece soil;
    soil.points.emplace_back(0.0f, 0.0f, 0.0f);
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double turn = 2.0 * std::numbers::pi * i / kSides;
      soil.points.emplace_back(0.27 * std::cos(turn), 0.0, 0.27 * std::sin(turn));
      soil.triangles.push_back({0, 1 + (i + 1) % kSides, 1 + i});
    }
    add_piece(std::move(soil), 2);
    for (std::uint32_t i = 0; i < kSides && plant_.pot == PotForm::facets; ++i) add_facet(2.0 * std::numbers::pi * i / kSides);
  }

  /// A plate on the pot's rim.
  void add_facet(double turn) {
    Piece facet;
    const glm::dvec3 out(std::cos(turn), 0.0, std::sin(turn)), side(-out.z, 0.0, out.x);
    for (const glm::dvec2& at : {glm::dvec2(-0.03, 0.0), glm::dvec2(0.03, 0.0), glm::dvec2(0.03, 0.06), glm::dvec2(-0.03, 0.06)})
      facet.points.emplace_back(0.32 * out + at.x * side + glm::dvec3(0.0, 0.02 + at.y, 0.0));
    facet.triangles = {{0, 1, 2}, {0, 2, 3}};
    add_piece(std::move(facet), 2);
  }

  void emit(TriangleSoup& soup) const {
    std::map<std::tuple<std::uint32_t, float, float, float>, std::uint32_t> shared;
    const auto vertex = [&](const Piece& piece, std::uint32_t point) {
      const glm::vec3& at = piece.points[point];
      const auto made = static_cast<std::uint32_t>(soup.mesh.positions.size());
      if (plant_.vertices == LobeVertices::per_leaf) {
        const auto [found, is_new] = shared.try_emplace({piece.owner, at.x, at.y, at.z}, made);
        if (!is_new) return found->second;
      }
      soup.mesh.positions.push_back(at);
      soup.mesh.normals.emplace_back(0.0f, 1.0f, 0.0f);
      soup.mesh.uvs.push_back(piece.uvs[point]);
      soup.vertex_instances.push_back(0);
      return made;
    };
    const auto emit_triangle = [&](const Piece& piece, std::size_t t, std::map<std::uint32_t, std::uint32_t>& made) {
      if (plant_.vertices == LobeVertices::per_triangle) made.clear();
      for (const std::uint32_t point : piece.triangles[t]) {
        const auto found = made.find(point);
        const std::uint32_t at = found != made.end() ? found->second : vertex(piece, point);
        made[point] = at;
        soup.mesh.indices.push_back(at);
      }
      soup.mesh.triangle_materials.push_back(piece.material);
    };
    for (std::size_t first = 0, last = 0; first < pieces_.size(); first = last) {
      const bool interleaved = plant_.order == LobeOrder::interleaved;
      do ++last;
      while (interleaved && last < pieces_.size() && pieces_[last].owner == pieces_[first].owner);
      std::vector<std::map<std::uint32_t, std::uint32_t>> made(last - first);
      std::size_t most = 0;
      for (std::size_t i = first; i < last; ++i) most = std::max(most, pieces_[i].triangles.size());
      for (std::size_t t = 0; t < most; ++t)
        for (std::size_t i = first; i < last; ++i)
          if (t < pieces_[i].triangles.size()) emit_triangle(pieces_[i], t, made[i - first]);
    }
  }

  LobedPlant plant_;
  SeededRandom random_, leaf_random_{0};
  glm::dmat3 twig_turn_{1.0};
  std::vector<Piece> pieces_;
  std::vector<glm::dvec3> joints_;
  glm::vec3 tip_before_{0.0f};
  std::uint32_t owner_ = 0;
};

}  // namespace

GrownPlant grow(const LobedPlant& plant) {
  return LobeGrower(plant).grow();
}

std::vector<LobedPlant> lobed_plants() {
  using enum LobeContact;
  using V = LobeVertices;
  using O = LobeOrder;
  using S = LobeSides;
  using D = Degenerate;
  using F = LobeForm;
  using H = LobeShape;
  using P = PotForm;
  using T = TwigForm;
  std::vector<LobedPlant> all{
      {.name = "ThreeLobes"},
      {.name = "ThreeLobesDoubled", .sides = S::both},
      {.name = "SycamoreStripTwigs", .sides = S::both, .twigs = T::strips},
      {.name = "SycamorePrismTwigs", .sides = S::both, .twigs = T::prisms},
      {.name = "SycamoreOnStripTwigs", .sides = S::both, .twigs = T::strips, .twigs_bear = true},
      {.name = "SycamoreOnPrismTwigs", .sides = S::repeated, .twigs = T::prisms, .twigs_bear = true},
      {.name = "SycamoreWithoutNames", .sides = S::both, .twigs = T::prisms, .has_names = false},
      {.name = "StripTwigsWithoutNames", .sides = S::both, .twigs = T::strips, .has_names = false},
      {.name = "TwoLobes", .lobe_count = 2, .sides = S::both},
      {.name = "FourLobesCorners", .lobe_count = 4, .contact = corner},
      {.name = "FiveLobes", .lobe_count = 5, .sides = S::both_with_own_vertices},
      {.name = "FiveLobesCorners", .lobe_count = 5, .contact = corner, .sides = S::both, .twigs = T::strips},
      {.name = "TwoLobesTwoPoints", .lobe_count = 2, .contact = two_points},
      {.name = "FiveLobesTwoPoints", .lobe_count = 5, .contact = two_points, .sides = S::repeated},
      {.name = "TwoLobesEdge", .lobe_count = 2, .contact = edge},
      {.name = "ThreeLobesEdgeDoubled", .contact = edge, .sides = S::both},
      {.name = "FiveLobesEdgeSharedVertices", .lobe_count = 5, .contact = edge, .vertices = V::per_leaf},
      {.name = "MirroredLobes", .form = F::mirrored, .sides = S::both},
      {.name = "FiveMirroredLobes", .lobe_count = 5, .form = F::mirrored},
      {.name = "EqualStrips", .contact = corner, .form = F::equal},
      {.name = "FourEqualStripsDoubled", .lobe_count = 4, .contact = corner, .form = F::equal, .sides = S::both},
      {.name = "EqualLobesFanned", .form = F::equal, .sides = S::both},
      {.name = "EqualLobesByImage", .form = F::equal, .has_uvs = true},
      {.name = "EqualBentLobesByImage", .form = F::equal, .has_uvs = true, .bend = 0.8},
      {.name = "BentLobesByImage", .sides = S::both, .twigs = T::strips, .has_uvs = true, .bend = 0.8},
      {.name = "BentLobes", .sides = S::both, .bend = 0.4},
      {.name = "MuchBentLobes", .sides = S::both, .bend = 0.9},
      {.name = "SharedVertices", .vertices = V::per_leaf},
      {.name = "WithoutIndices", .sides = S::both, .vertices = V::per_triangle},
      {.name = "AllFirstLobesFirst", .sides = S::both, .order = O::by_lobe, .twigs = T::strips},
      {.name = "Shuffled", .order = O::shuffled, .twigs = T::prisms},
      {.name = "Interleaved", .sides = S::both, .order = O::interleaved},
      {.name = "TouchingLeaves", .sides = S::both, .touching = 0.1},
      {.name = "TouchingLeavesShuffled", .order = O::shuffled, .touching = 0.3},
      {.name = "PotAndCollapsed", .sides = S::both, .pot = P::round, .degenerate = D::collapsed},
      {.name = "PotAndSlivers", .pot = P::round, .degenerate = D::slivers},
      {.name = "PotAndSliversDoubled", .sides = S::both, .pot = P::round, .degenerate = D::both},
      {.name = "FigEdges", .lobe_count = 5, .contact = edge, .pot = P::round, .degenerate = D::both, .touching = 0.07},
      {.name = "FigPoints",
       .lobe_count = 5,
       .contact = corner,
       .vertices = V::per_triangle,
       .pot = P::round,
       .degenerate = D::both,
       .touching = 0.07},
      {.name = "FacettedPot", .contact = edge, .pot = P::facets},
      {.name = "FacettedPotWithoutNames", .contact = edge, .pot = P::facets, .has_names = false},
      {.name = "Pyramids", .shape = H::pyramid},
      {.name = "PyramidsOnTwigs", .twigs = T::prisms, .twigs_bear = true, .shape = H::pyramid, .instanced_twigs = true},
      {.name = "PyramidsEdge", .lobe_count = 5, .contact = edge, .shape = H::pyramid},
      {.name = "PyramidsTwoPoints", .lobe_count = 2, .contact = two_points, .twigs = T::strips, .shape = H::pyramid},
      {.name = "PyramidsMirrored", .form = F::mirrored, .order = O::by_lobe, .shape = H::pyramid},
      {.name = "UnlikeLobes", .sides = S::both, .twigs = T::strips, .twigs_bear = true, .shape = H::unlike},
      {.name = "UnlikeLobesInstanced",
       .sides = S::both,
       .twigs = T::prisms,
       .twigs_bear = true,
       .shape = H::unlike,
       .instanced_twigs = true},
      {.name = "UnlikeLobesTouching", .lobe_count = 5, .shape = H::unlike, .touching = 0.2},
      {.name = "InstancedStripTwigs", .sides = S::both, .twigs = T::strips, .twigs_bear = true, .instanced_twigs = true, .bend = 0.4},
      {.name = "InstancedPrismTwigs", .sides = S::both, .twigs = T::prisms, .instanced_twigs = true, .bend = 0.8},
      {.name = "ShuffledTriangles", .sides = S::both, .shuffled_triangles = true},
      {.name = "WhorlsAreLeaves", .form = F::equal, .sides = S::both, .are_leaves = true, .step = 2.1, .cone = 0.5},
      {.name = "FlatWhorlsAreLeaves", .form = F::equal, .are_leaves = true, .step = 2.0944},
      {.name = "PairsAreLeaves", .lobe_count = 2, .form = F::equal, .are_leaves = true, .step = 2.6, .cone = 0.4},
      {.name = "MirroredPairsAreLeaves", .lobe_count = 2, .form = F::mirrored, .are_leaves = true, .step = 2.6, .cone = 0.4},
      {.name = "PairsOnTwigsAreLeaves",
       .lobe_count = 2,
       .form = F::equal,
       .twigs = T::strips,
       .twigs_bear = true,
       .instanced_twigs = true,
       .are_leaves = true,
       .step = 2.6},
      {.name = "LeafletsAreLeaves", .lobe_count = 5, .form = F::equal, .has_uvs = true, .are_leaves = true, .step = 0.8},
      {.name = "DroopingLeafletsAreLeaves", .lobe_count = 5, .form = F::equal, .are_leaves = true, .step = 0.8, .cone = -0.4, .bend = 0.3},
      {.name = "LeavesOnTwigs", .lobe_count = 1, .sides = S::both, .twigs = T::strips, .twigs_bear = true, .instanced_twigs = true},
      {.name = "BentLeavesOnTwigs",
       .lobe_count = 1,
       .sides = S::both,
       .twigs = T::strips,
       .twigs_bear = true,
       .instanced_twigs = true,
       .bend = 0.8},
      {.name = "Rounded", .sides = S::both, .twigs = T::strips, .twigs_bear = true, .step_m = 1e-4},
  };
  std::uint32_t seed = 1;
  for (LobedPlant& plant : all) plant.seed = seed++;
  return all;
}

}  // namespace coppice::bake::test
