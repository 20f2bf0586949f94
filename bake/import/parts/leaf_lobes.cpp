// Contacts between pieces are sorted by what touches what, and each sort is judged as a whole: either it holds lobes together, or leaves
// merely happen to touch. Only pieces of sizes that touch anywhere are looked at; most plants have none.

#include "leaf_lobes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <tuple>
#include <unordered_map>
#include <utility>

#include <glm/geometric.hpp>

#include "piece_kinds.h"
#include "union_find.h"

namespace coppice::bake {
namespace {

// Maximum number of a lobe's triangles.
constexpr std::size_t kMaxTriangles = 128;
// Maximum number of pieces at a point; more hang on one point.
constexpr std::size_t kMaxAtPoint = 16;
// Share of the pieces that must have a sort of contact to make it the way a leaf is made: some pieces are damaged, some touch others too.
constexpr double kNearlyAll = 0.85;

/// Two pieces and the points at which they touch, in each one's numbers.
struct Contact {
  std::uint32_t a = 0, b = 0;  ///< pieces
  std::vector<std::uint32_t> points_a, points_b;
};

/// A point at which several pieces meet, and one of them; in order.
using Meeting = std::pair<std::uint32_t, std::uint32_t>;
std::vector<Meeting> find_meetings(const Points& points, const std::vector<std::uint32_t>& piece_of) {
  std::vector<std::uint32_t> first_at(points.count(), kNone);
  std::vector<Meeting> meetings;
  for (std::uint32_t t = 0; t < piece_of.size(); ++t) {
    if (piece_of[t] == kNone) continue;
    for (const std::uint32_t point : points.of(t)) {
      if (first_at[point] == kNone) first_at[point] = piece_of[t];
      if (first_at[point] == piece_of[t]) continue;
      meetings.emplace_back(point, first_at[point]);
      meetings.emplace_back(point, piece_of[t]);
    }
  }
  std::ranges::sort(meetings);
  meetings.erase(std::unique(meetings.begin(), meetings.end()), meetings.end());
  return meetings;
}

class LobeJoiner {
 public:
  LobeJoiner(const Mesh& mesh, const Points& points, std::vector<std::uint32_t>& piece_of)
      : mesh_(mesh), points_(points), piece_of_(piece_of), joined_(piece_of.size()) {}

  void join() {
    const std::vector<Meeting> meetings = find_meetings(points_, piece_of_);
    if (meetings.empty()) return;
    number_pieces(meetings);
    table_ = find_kinds(mesh_, pieces_);
    find_contacts(meetings);
    join_partners();
    join_complements();
    join_strips();
    join_fans(meetings);
    for (std::uint32_t& piece : piece_of_)
      if (piece != kNone) piece = joined_.find(piece);
  }

 private:
  [[nodiscard]] const PieceShape& shape_of(std::uint32_t piece) const { return table_.kinds[pieces_[piece].kind].shape; }
  void unite(std::uint32_t a, std::uint32_t b) { joined_.join(pieces_[a].first_triangle, pieces_[b].first_triangle); }

  /// Numbers all pieces of the sizes that touch anywhere.
  void number_pieces(const std::vector<Meeting>& meetings) {
    std::vector<std::uint32_t> triangles;
    for (std::uint32_t t = 0; t < piece_of_.size(); ++t)
      if (piece_of_[t] != kNone) triangles.push_back(t);
    const Groups sorted = group_by(triangles, piece_of_.size(), [&](std::uint32_t t) { return piece_of_[t]; });
    std::set<std::pair<std::uint32_t, std::size_t>> sizes;
    std::vector<bool> meets(piece_of_.size(), false);
    for (const auto& [point, piece] : meetings) meets[piece] = true;
    const auto size_of = [&](std::size_t i) { return std::pair{mesh_.triangle_materials[sorted.of(i)[0]], sorted.of(i).size()}; };
    for (std::size_t i = 0; i < sorted.ranges.size(); ++i)
      if (meets[sorted.of(i)[0]] && sorted.of(i).size() <= kMaxTriangles) sizes.insert(size_of(i));
    number_of_.assign(piece_of_.size(), kNone);
    for (std::size_t i = 0; i < sorted.ranges.size(); ++i) {
      if (!sizes.contains(size_of(i))) continue;
      number_of_[sorted.of(i)[0]] = static_cast<std::uint32_t>(pieces_.size());
      pieces_.push_back(number_piece(mesh_, points_, sorted.of(i)));
    }
  }

  /// The number of a point within a piece; the number of its points if only triangles without area have it.
  [[nodiscard]] std::uint32_t number_in(std::uint32_t piece, std::uint32_t point) const {
    const auto& all = pieces_[piece].points;
    return static_cast<std::uint32_t>(std::ranges::find(all, point) - all.begin());
  }

  /// Calls visit(point, pieces) for each point at which pieces that have a kind meet.
  template <class Visit>
  void visit_meetings(const std::vector<Meeting>& meetings, const Visit& visit) const {
    for (std::size_t first = 0, last = 0; first < meetings.size(); first = last) {
      std::vector<std::uint32_t> here;
      for (; last < meetings.size() && meetings[last].first == meetings[first].first; ++last) {
        const std::uint32_t piece = number_of_[meetings[last].second];
        if (piece != kNone && pieces_[piece].kind != kNone) here.push_back(piece);
      }
      if (here.size() > 1 && last - first <= kMaxAtPoint) visit(meetings[first].first, here);
    }
  }

  void find_contacts(const std::vector<Meeting>& meetings) {
    std::vector<std::array<std::uint32_t, 3>> touches;
    visit_meetings(meetings, [&](std::uint32_t point, const std::vector<std::uint32_t>& here) {
      for (std::size_t i = 0; i < here.size(); ++i)
        for (std::size_t k = i + 1; k < here.size(); ++k) touches.push_back({here[i], here[k], point});
    });
    std::ranges::sort(touches);
    for (const auto& [a, b, point] : touches) {
      const std::uint32_t in_a = number_in(a, point), in_b = number_in(b, point);
      if (in_a == pieces_[a].points.size() || in_b == pieces_[b].points.size()) continue;
      if (contacts_.empty() || contacts_.back().a != a || contacts_.back().b != b) contacts_.push_back({a, b, {}, {}});
      contacts_.back().points_a.push_back(in_a);
      contacts_.back().points_b.push_back(in_b);
    }
    for (Contact& contact : contacts_) {
      std::ranges::sort(contact.points_a);
      std::ranges::sort(contact.points_b);
    }
  }

  using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

  /// All pieces of one kind, or of all kinds of one topology.
  struct Group {
    bool is_kind = false;
    std::uint32_t number = 0;
    auto operator<=>(const Group&) const = default;
  };
  [[nodiscard]] std::uint32_t count(const Group& group) const {
    return group.is_kind ? table_.kinds[group.number].count : table_.topology_counts[group.number];
  }

  /// A sort of contact: what touches what, and where.
  struct Sort {
    Group a, b;
    std::vector<std::uint32_t> points_a, points_b;
    auto operator<=>(const Sort&) const = default;
  };
  using Sorts = std::map<Sort, Pairs>;

  static void add(Sorts& sorts, const Contact& contact, const Group& a, const Group& b, bool with_points) {
    const bool swapped = b < a;
    Sort sort{swapped ? b : a, swapped ? a : b, {}, {}};
    if (with_points) sort.points_a = swapped ? contact.points_b : contact.points_a;
    if (with_points) sort.points_b = swapped ? contact.points_a : contact.points_b;
    sorts[sort].emplace_back(swapped ? contact.b : contact.a, swapped ? contact.a : contact.b);
  }

  /// Joins contacts between different kinds, one of each. If topologies differ too, all pieces of one topology must take part: a leaf may
  /// have a kind for each place on an instanced twig, and so may the twig. Looks first at which points touch, then at the kinds alone.
  void join_partners() {
    for (const bool with_points : {true, false}) {
      Sorts sorts;
      for (const Contact& contact : contacts_) {
        const NumberedPiece &first = pieces_[contact.a], &second = pieces_[contact.b];
        if (first.kind == second.kind) continue;
        const Group kind_a{true, first.kind}, kind_b{true, second.kind}, all_a{false, first.topology}, all_b{false, second.topology};
        if (first.topology == second.topology) {
          add(sorts, contact, kind_a, kind_b, with_points);
          continue;
        }
        add(sorts, contact, all_a, all_b, with_points);
        add(sorts, contact, all_a, kind_b, with_points);
        add(sorts, contact, kind_a, all_b, with_points);
      }
      for (const auto& [sort, pairs] : sorts) {
        // Groups that are joined at one place may touch by chance at others.
        if (partners_.contains({sort.a, sort.b}) && !with_points) continue;
        if (join_if_partners(pairs, count(sort.a), count(sort.b))) partners_.insert({sort.a, sort.b});
      }
    }
  }

  /// Joins the pairs if nearly all of both groups have one partner, or two, in the other, or if one group is twice as many. Returns whether
  /// it did.
  bool join_if_partners(Pairs pairs, std::uint32_t count_a, std::uint32_t count_b) {
    if (count_a > count_b) {
      std::swap(count_a, count_b);
      for (auto& [a, b] : pairs) std::swap(a, b);
    }
    const double ratio = static_cast<double>(count_b) / static_cast<double>(count_a);
    const auto each = static_cast<std::uint32_t>(std::lround(ratio));
    if (count_a < kRepeated || each > 2 || std::abs(ratio - each) > 0.1 * each || !may_be_one(pairs[0].first, pairs[0].second, each))
      return false;
    std::unordered_map<std::uint32_t, std::uint32_t> degree_a, degree_b;
    for (const auto& [a, b] : pairs) ++degree_a[a], ++degree_b[b];
    const auto have = [](const auto& degrees, std::uint32_t degree) {
      return static_cast<double>(std::ranges::count_if(degrees, [&](const auto& entry) { return entry.second == degree; }));
    };
    for (const std::uint32_t degree : {1u, 2u}) {
      if (have(degree_b, degree) < kNearlyAll * count_b || have(degree_a, each * degree) < kNearlyAll * count_a) continue;
      if (degree == 1) {
        join_nearest(pairs);
      } else {  // two and two at one point touch crosswise
        for (const auto& [a, b] : pairs)
          if (degree_a[a] == each * degree && degree_b[b] == degree) unite(a, b);
      }
      return true;
    }
    return false;
  }

  /// Joins a lobe that comes in several kinds, one for each leaf of an instanced twig: every piece of them touches just one of a third
  /// kind, which touches one of them.
  void join_complements() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, Pairs> sorts;
    for (const Contact& contact : contacts_) {
      const NumberedPiece &first = pieces_[contact.a], &second = pieces_[contact.b];
      if (first.kind == second.kind || first.topology != second.topology) continue;
      sorts[{first.kind, second.kind}].emplace_back(contact.a, contact.b);
      sorts[{second.kind, first.kind}].emplace_back(contact.b, contact.a);
    }
    std::vector<Pairs> complements(table_.kinds.size());
    std::vector<std::uint32_t> counts(table_.kinds.size(), 0);
    for (const auto& [sort, pairs] : sorts) {
      const auto& [of, other] = sort;
      if (partners_.contains({{true, std::min(of, other)}, {true, std::max(of, other)}})) continue;
      std::set<std::uint32_t> others;
      for (const auto& [a, b] : pairs) others.insert(b);
      const std::uint32_t count = table_.kinds[other].count;
      if (count > table_.kinds[of].count || static_cast<double>(others.size()) < kNearlyAll * count) continue;
      counts[of] += count;
      complements[of].insert(complements[of].end(), pairs.begin(), pairs.end());
    }
    for (std::uint32_t kind = 0; kind < complements.size(); ++kind)
      if (!complements[kind].empty()) join_if_partners(complements[kind], table_.kinds[kind].count, counts[kind]);
  }

  /// Joins each second piece with the one first piece that is nearest in the file.
  void join_nearest(Pairs& pairs) {
    const auto distance = [](const auto& pair) { return pair.first > pair.second ? pair.first - pair.second : pair.second - pair.first; };
    std::ranges::stable_sort(
        pairs, [&](const auto& x, const auto& y) { return x.second != y.second ? x.second < y.second : distance(x) < distance(y); });
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (i == 0 || pairs[i].second != pairs[i - 1].second) unite(pairs[i].first, pairs[i].second);
  }

  /// Whether both can belong to one leaf: a sheet is no part of a tube, a blade none of its stalk. If `each` is 2, two alike pieces stand
  /// beside one that is at most three times as long or short.
  [[nodiscard]] bool may_be_one(std::uint32_t a, std::uint32_t b, std::uint32_t each) const {
    constexpr double kSlender = 2.5, kAboutAsLong = 3.0;
    const PieceShape &first = shape_of(a), &second = shape_of(b);
    if ((first.flatness < kTubeFlatness) != (second.flatness < kTubeFlatness)) return false;
    if (std::max(first.elongation(), second.elongation()) > kSlender * std::min(first.elongation(), second.elongation())) return false;
    return each == 1 || std::max(first.length_m, second.length_m) <= kAboutAsLong * std::min(first.length_m, second.length_m);
  }

  /// Joins copies side by side, or end to end if they are slender: all of one topology if all are so, else all of one kind.
  void join_strips() {
    for (const bool by_kind : {false, true}) {
      std::map<std::tuple<std::uint32_t, std::vector<std::uint32_t>, std::vector<std::uint32_t>>, Pairs> sorts;
      for (const Contact& contact : contacts_) {
        const auto sort_of = [&](std::uint32_t piece) { return by_kind ? pieces_[piece].kind : pieces_[piece].topology; };
        const std::uint32_t sort = sort_of(contact.a);
        if (sort != sort_of(contact.b)) continue;
        if (contact.points_a <= contact.points_b)
          sorts[{sort, contact.points_a, contact.points_b}].emplace_back(contact.a, contact.b);
        else
          sorts[{sort, contact.points_b, contact.points_a}].emplace_back(contact.b, contact.a);
      }
      for (const auto& [sort, pairs] : sorts) {
        const auto& [of, points_a, points_b] = sort;
        if (points_a == points_b ? points_a.size() > 1 : may_be_strips(pairs[0].first, points_a, points_b))
          join_if_chains(pairs, by_kind ? table_.kinds[of].count : table_.topology_counts[of]);
      }
    }
  }

  [[nodiscard]] bool may_be_strips(std::uint32_t piece, const std::vector<std::uint32_t>& points_a,
                                   const std::vector<std::uint32_t>& points_b) const {
    constexpr double kSideBySide = 0.6, kSlender = 4.0;
    const PieceShape& shape = shape_of(piece);
    const auto& vertices = pieces_[piece].vertices;
    double nearest_m = shape.length_m;
    for (const std::uint32_t a : points_a)
      for (const std::uint32_t b : points_b)
        nearest_m = std::min(nearest_m, static_cast<double>(glm::distance(mesh_.positions[vertices[a]], mesh_.positions[vertices[b]])));
    const double longest_m = std::max(shape.length_m, 1e-30);
    return nearest_m < kSideBySide * longest_m || shape.elongation() >= kSlender;
  }

  /// Joins the pairs if nearly all pieces are in chains of equal length that are no rings.
  void join_if_chains(const Pairs& pairs, std::uint32_t count) {
    constexpr std::size_t kLongest = 8;
    UnionFind chains(pieces_.size());
    std::map<std::uint32_t, std::uint32_t> before, after;
    for (const auto& [a, b] : pairs) {
      ++after[a], ++before[b];
      chains.join(a, b);
    }
    std::map<std::uint32_t, std::size_t> lengths, links;
    std::set<std::uint32_t> members;
    for (const auto& [a, b] : pairs) {
      members.insert({a, b});
      ++links[chains.find(a)];
    }
    for (const std::uint32_t member : members) ++lengths[chains.find(member)];
    std::map<std::size_t, std::size_t> in_chains_of;
    for (const auto& [chain, length] : lengths)
      if (links[chain] == length - 1) in_chains_of[length] += length;
    const auto usual = std::ranges::max_element(in_chains_of, {}, [](const auto& entry) { return entry.second; });
    if (usual == in_chains_of.end() || usual->first > kLongest || static_cast<double>(usual->second) < kNearlyAll * count) return;
    for (const auto& [a, b] : pairs)
      if (lengths[chains.find(a)] == usual->first && links[chains.find(a)] == usual->first - 1) unite(a, b);
  }

  /// Joins copies in one plane that are fanned out of one point.
  void join_fans(const std::vector<Meeting>& meetings) {
    using Fan = std::vector<std::uint32_t>;
    std::map<std::tuple<std::uint32_t, std::uint32_t, std::size_t>, std::vector<Fan>> sorts;
    visit_meetings(meetings, [&](std::uint32_t point, const std::vector<std::uint32_t>& here) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, Fan> fans;
      for (const std::uint32_t piece : here) fans[{pieces_[piece].kind, number_in(piece, point)}].push_back(piece);
      for (auto& [sort, fan] : fans)
        if (fan.size() > 2 && !table_.kinds[sort.first].has_image_part && is_flat_fan(fan, sort.second))
          sorts[{sort.first, sort.second, fan.size()}].push_back(std::move(fan));
    });
    for (const auto& [sort, fans] : sorts) {
      const auto& [kind, point, size] = sort;
      if (static_cast<double>(fans.size() * size) < kNearlyAll * table_.kinds[kind].count) continue;
      for (const Fan& fan : fans)
        for (const std::uint32_t piece : fan) unite(fan[0], piece);
    }
  }

  [[nodiscard]] glm::dvec3 position(std::uint32_t piece, std::uint32_t number) const {
    return {mesh_.positions[pieces_[piece].vertices[number]]};
  }

  /// Whether all points are in one plane, and the directions from the common point open by at most a right angle each, apart from one
  /// larger opening.
  [[nodiscard]] bool is_flat_fan(const std::vector<std::uint32_t>& fan, std::uint32_t number) const {
    constexpr double kOffPlane = 0.01, kWidestStep = 0.5 * std::numbers::pi;
    const glm::dvec3 center = position(fan[0], number);
    std::vector<glm::dvec3> directions;
    glm::dvec3 normal(0.0);
    double radius_m = 0.0;
    for (const std::uint32_t piece : fan) {
      glm::dvec3 sum(0.0);
      for (std::uint32_t i = 0; i < pieces_[piece].points.size(); ++i) {
        sum += position(piece, i) - center;
        radius_m = std::max(radius_m, glm::distance(position(piece, i), center));
      }
      directions.push_back(sum / static_cast<double>(pieces_[piece].points.size()));
      const glm::dvec3 across = glm::cross(directions[0], directions.back());
      if (glm::length(across) > glm::length(normal)) normal = across;
    }
    if (glm::length(normal) <= 0.0) return false;
    normal = glm::normalize(normal);
    for (const std::uint32_t piece : fan)
      for (std::uint32_t i = 0; i < pieces_[piece].points.size(); ++i)
        if (std::abs(glm::dot(position(piece, i) - center, normal)) > kOffPlane * radius_m) return false;
    std::vector<double> angles;
    const glm::dvec3 x = glm::normalize(directions[0]), y = glm::cross(normal, x);
    for (const glm::dvec3& direction : directions) angles.push_back(std::atan2(glm::dot(direction, y), glm::dot(direction, x)));
    std::ranges::sort(angles);
    std::vector<double> steps{angles.front() + 2.0 * std::numbers::pi - angles.back()};
    for (std::size_t i = 1; i < angles.size(); ++i) steps.push_back(angles[i] - angles[i - 1]);
    std::ranges::sort(steps);
    return steps[steps.size() - 2] <= kWidestStep && steps.back() > kWidestStep;
  }

  const Mesh& mesh_;
  const Points& points_;
  std::vector<std::uint32_t>& piece_of_;
  UnionFind joined_;  ///< joins first triangles of pieces
  std::vector<NumberedPiece> pieces_;
  std::vector<std::uint32_t> number_of_;  ///< [triangle count] number of the piece with this first triangle; kNone if it is not looked at
  KindTable table_;
  std::vector<Contact> contacts_;
  std::set<std::pair<Group, Group>> partners_;  ///< the groups that were joined, the smaller first
};

}  // namespace

void join_lobes(const Mesh& mesh, const Points& points, std::vector<std::uint32_t>& piece_of) {
  LobeJoiner(mesh, points, piece_of).join();
}

}  // namespace coppice::bake
