#include "find_leaves.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "leaf_pieces.h"
#include "material_words.h"
#include "parallel_for.h"
#include "piece_points.h"
#include "piece_shape.h"
#include "text_number.h"
#include "texture_mips.h"
#include "weld.h"

namespace coppice::bake {
namespace {

// Minimum flatness of a leaf. Between this and kTubeFlatness a piece may be either.
constexpr double kFlat = 0.75;
// Half way from the flatness of a tube to that of a ball.
constexpr double kBall = 0.45;
// Minimum bulk (piece_shape.h) of a body: a blob of a crown, a cone, a cactus.
constexpr double kBody = 0.2;
// Minimum size of a class that says what the leaves of its material look like.
constexpr std::uint32_t kMinCompany = 8;
// Share of a plant's surface from which on pieces count although their material's name says that they are wood, and sheets do.
constexpr double kMuch = 0.1, kMostly = 0.3;

/// Interpolates from (x0, y0) to (x1, y1), and is level outside.
double ramp(double x, double x0, double y0, double x1, double y1) {
  return y0 + (y1 - y0) * std::clamp((x - x0) / (x1 - x0), 0.0, 1.0);
}

/// The value below which this share of `values` lies.
double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

bool has_holes(const Material& material, const std::vector<Image>& images) {
  // Images that were saved with alpha for no reason have stray texels.
  constexpr double kMaxCoverage = 0.98;
  return material.alpha_cutoff > 0.0f && material.image != kNone &&
         alpha_coverage(images[material.image], material.alpha_cutoff) < kMaxCoverage;
}

/// The texel at a coordinate. Textures repeat.
const std::uint8_t* texel_at(const Image& image, const glm::vec2& uv) {
  const auto along = [](float coordinate, std::uint32_t size) {
    const auto texel = static_cast<std::uint32_t>(glm::fract(coordinate) * static_cast<float>(size));
    return std::min(texel, size - 1);
  };
  return &image.rgba[4 * (std::size_t{along(uv.y, image.height)} * image.width + along(uv.x, image.width))];
}

/// Samples the mean linear colour of what triangles show; black if they show nothing.
glm::dvec3 mean_color(const Mesh& mesh, std::span<const std::uint32_t> triangles, const Material& material,
                      const std::vector<Image>& images) {
  const glm::dvec3 factor(material.base_color);
  if (material.image == kNone) return factor;
  constexpr std::array<std::array<float, 3>, 4> kSamples{
      {{0.333f, 0.333f, 0.334f}, {0.6f, 0.2f, 0.2f}, {0.2f, 0.6f, 0.2f}, {0.2f, 0.2f, 0.6f}}};
  const Image& image = images[material.image];
  glm::dvec3 sum(0.0);
  std::size_t count = 0;
  for (const std::uint32_t t : triangles)
    for (const auto& weights : kSamples) {
      glm::vec2 uv(0.0f);
      for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * mesh.uvs[mesh.indices[3 * std::size_t{t} + k]];
      const std::uint8_t* texel = texel_at(image, uv);
      if (static_cast<float>(texel[3]) < material.alpha_cutoff * 255.0f) continue;
      for (int c = 0; c < 3; ++c) sum[c] += std::pow(texel[c] / 255.0, 2.2);
      ++count;
    }
  return count > 0 ? factor * sum / static_cast<double>(count) : glm::dvec3(0.0);
}

double colour_evidence(const glm::dvec3& linear) {
  const double other = std::max(linear.r, linear.b);
  if (linear.g > other) return ramp(linear.g / std::max(other, 1e-6), 1.0, 0.0, 1.25, 0.75);
  const bool brown = linear.r > 1.1 * linear.g && linear.g > linear.b;
  return brown ? -0.5 : 0.0;
}

double flatness_evidence(double flatness, bool holes) {
  const double value = flatness < kFlat ? ramp(flatness, 0.6, -2.5, kFlat, 0.25) : ramp(flatness, kFlat, 0.25, 0.85, 1.25);
  return holes ? std::max(value, -0.5) : value;
}

/// Counts for each material how many pieces are about as large in triangles and length, in steps of two.
class Kin {
 public:
  explicit Kin(const std::vector<PieceClass>& classes) {
    for (const PieceClass& each : classes) counts_[step_of(each)] += each.piece_count;
  }

  /// Number of pieces that are at most a step away in both.
  [[nodiscard]] double count(const PieceClass& of) const {
    const auto [material, triangles, length] = step_of(of);
    std::uint64_t sum = 0;
    for (int i = -1; i <= 1; ++i)
      for (int k = -1; k <= 1; ++k) {
        const auto found = counts_.find({material, triangles + i, length + k});
        if (found != counts_.end()) sum += found->second;
      }
    return static_cast<double>(sum);
  }

 private:
  using Step = std::tuple<std::uint32_t, int, int>;
  static Step step_of(const PieceClass& of) {
    return {of.material, std::ilogb(static_cast<double>(of.triangle_count)), std::ilogb(of.length_m)};
  }
  std::map<Step, std::uint64_t> counts_;
};

double repetition_evidence(double count) {
  return std::clamp(0.65 * std::log10(count), 0.0, 2.6);
}

/// Finds a material's most repeated class of flat pieces, or a class of pieces that are not round if it has twice as many; none if nothing
/// is repeated.
std::optional<std::size_t> main_class(std::span<const PieceClass> of_material) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < of_material.size(); ++i) {
    const PieceClass& each = of_material[i];
    if (each.piece_count < kMinCompany || each.flatness < kTubeFlatness) continue;
    if (!first) first = i;
    if (each.flatness >= kFlat) return of_material[*first].piece_count >= 2 * each.piece_count ? first : i;
  }
  return first;
}

/// Evidence against pieces beside leaves: round ones, those many times as long and of another shape, and those longer and much more
/// slender.
double company_evidence(const PieceClass& of, const PieceClass& leaves) {
  // All other evidence speaks for slender pieces as for leaves, so their penalty is larger.
  constexpr double kOdd = -4.0, kSlender = -8.0;
  if (of.piece_count >= leaves.piece_count) return 0.0;
  const bool is_slender = of.length_m >= 1.5 * leaves.length_m && of.slenderness >= 4.0 * leaves.slenderness && of.slenderness >= 15.0;
  if (is_slender) return kSlender;
  const bool is_tube = of.flatness < kTubeFlatness && of.elongation >= 3.0, is_ball = of.flatness < kBall;
  const bool is_longer = of.length_m >= 4.0 * leaves.length_m && of.triangle_count > leaves.triangle_count &&
                         (of.triangle_count >= 2 * leaves.triangle_count || of.elongation >= 3.0 * leaves.elongation);
  const bool is_bulky = of.flatness < kFlat && of.triangle_count >= 8 * leaves.triangle_count && of.length_m >= 2.0 * leaves.length_m;
  return is_tube || is_ball || is_longer || is_bulky ? kOdd : 0.0;
}

std::string explain(const PieceClass& of) {
  const LeafEvidence& evidence = of.evidence;
  std::string text;
  const auto add = [&](double value, const std::string& what) {
    if (std::abs(value) >= 0.05) text += (text.empty() ? "" : ", ") + what + formatted(" %+.1f", value);
  };
  add(evidence.name, "name");
  add(evidence.holes, "holes");
  add(evidence.colour, evidence.colour > 0.0 ? "green" : "brown");
  add(evidence.flatness, formatted("flat %.2f", of.flatness));
  add(evidence.repetition, "repeated");
  add(evidence.size, evidence.size > 0.0 ? "small" : "large");
  add(evidence.company, "unlike the leaves beside it");
  return text + formatted(" = %.1f", evidence.sum());
}

const MaterialRule* fitting_rule(const std::vector<MaterialRule>& rules, std::uint32_t triangle_count) {
  const auto found = std::ranges::find_if(
      rules, [&](const MaterialRule& rule) { return rule.min_triangles <= triangle_count && triangle_count <= rule.max_triangles; });
  return found == rules.end() ? nullptr : &*found;
}

/// Whether sheets may have a name that speaks for wood.
enum class NamesOfWood : std::uint8_t { heeded, ignored };

struct ClassedPieces {
  std::vector<PieceClass> classes;      ///< by material, then most pieces first
  std::vector<double> bulks;            ///< [class count] medians; see piece_shape.h
  std::vector<double> areas_m2;         ///< [class count] sums
  std::vector<std::uint32_t> class_of;  ///< [piece count] kNone for pieces that are left out
};

/// [class] A sample of its triangles.
std::vector<std::vector<std::uint32_t>> sample_classes(const Pieces& pieces, const ClassedPieces& classed) {
  // These are enough for a mean colour.
  constexpr std::size_t kMaxSampled = 256;
  std::vector<std::vector<std::uint32_t>> samples(classed.classes.size());
  for (std::size_t i = 0; i < pieces.ranges.size(); ++i) {
    if (classed.class_of[i] == kNone) continue;
    std::vector<std::uint32_t>& sample = samples[classed.class_of[i]];
    const TriangleList triangles = pieces.of(i);
    const TriangleList taken = triangles.first(std::min(triangles.size(), kMaxSampled - sample.size()));
    sample.insert(sample.end(), taken.begin(), taken.end());
  }
  return samples;
}

void judge(PieceClass& of, double extent_m) {
  of.evidence.size = ramp(std::log(std::max(of.length_m, 1e-12) / std::max(extent_m, 1e-12)), std::log(0.15), 0.25, std::log(0.5), -2.0);
  of.part = of.evidence.sum() >= kLeafScore ? PlantPart::leaf : PlantPart::wood;
  of.is_shell =
      of.part == PlantPart::wood && of.evidence.name + of.evidence.holes >= 1.0 && of.evidence.company == 0.0 && of.evidence.flatness < 0.0;
  of.reason = explain(of);
}

/// Whether neither name, holes nor green speak for leaves.
bool is_only_form(const PieceClass& of) {
  return of.evidence.sum() != 0.0 && of.evidence.name <= 0.0 && of.evidence.holes <= 0.0 && of.evidence.colour <= 0.0;
}

/// The class of leaves that has the most pieces; null without any.
const PieceClass* most_leaves(const std::vector<PieceClass>& classes) {
  const PieceClass* most = nullptr;
  for (const PieceClass& each : classes)
    if (each.part == PlantPart::leaf && (!most || each.piece_count > most->piece_count)) most = &each;
  return most;
}

/// Makes wood of pieces below all leaves for which only their form speaks: plates and gravel of a pot.
void judge_what_is_below(std::vector<PieceClass>& classes, double extent_m) {
  constexpr double kBelow = -2.5;
  constexpr std::uint64_t kFewer = 10;
  const PieceClass* const leaves = most_leaves(classes);
  if (!leaves) return;
  std::map<std::uint32_t, std::uint64_t> leaf_counts;
  for (const PieceClass& each : classes)
    if (each.part == PlantPart::leaf) leaf_counts[each.material] += each.piece_count;
  for (PieceClass& of : classes) {
    if (of.part != PlantPart::leaf || of.material == leaves->material || !is_only_form(of)) continue;
    if (kFewer * of.piece_count > leaf_counts[leaves->material] || of.high_m >= leaves->low_m) continue;
    of.evidence.company += kBelow;
    judge(of, extent_m);
  }
}

/// Area of the classes for which `is_one` is true of their number.
double area_m2(const ClassedPieces& classed, const auto& is_one) {
  double sum_m2 = 0.0;
  for (std::size_t i = 0; i < classed.classes.size(); ++i)
    if (is_one(i)) sum_m2 += classed.areas_m2[i];
  return sum_m2;
}

double leaf_area_m2(const ClassedPieces& classed) {
  return area_m2(classed, [&](std::size_t i) { return classed.classes[i].part == PlantPart::leaf; });
}

/// Without ground and walls: flat wood of one or two pieces.
double whole_area_m2(const ClassedPieces& classed) {
  return area_m2(classed, [&](std::size_t i) {
    const PieceClass& of = classed.classes[i];
    return of.part == PlantPart::leaf || of.piece_count > 2 || of.flatness < kFlat;
  });
}

/// Whether there are leaves that are no mere marks, splinters or weeds at the foot, or that a person named.
bool has_crown(const ClassedPieces& classed) {
  constexpr std::uint64_t kMany = 100;
  constexpr double kShare = 0.02, kShareOfFew = 0.1, kHigh = 0.75;
  std::uint64_t count = 0;
  double foot_m = std::numeric_limits<double>::max(), top_m = -foot_m, leaf_top_m = -foot_m;
  for (const PieceClass& each : classed.classes) {
    foot_m = std::min(foot_m, each.low_m);
    top_m = std::max(top_m, each.high_m);
    if (each.part != PlantPart::leaf) continue;
    if (each.evidence.sum() == 0.0) return true;  // a rule decided
    count += each.piece_count;
    leaf_top_m = std::max(leaf_top_m, each.high_m);
  }
  if (count >= kMany && leaf_top_m >= foot_m + kHigh * (top_m - foot_m)) return true;  // spines of a cactus, say
  return count > 0 && leaf_area_m2(classed) >= (count < kMinCompany ? kShareOfFew : kShare) * whole_area_m2(classed);
}

/// Makes leaves of what would be leaves if the name did not speak for wood (find_leaves.h).
void judge_against_names(ClassedPieces& classed, double extent_m) {
  const PieceClass* const leaves = most_leaves(classed.classes);
  const auto contradicts = [&](std::size_t i) {
    const PieceClass& of = classed.classes[i];
    if (leaves && company_evidence(of, *leaves) < 0.0) return false;  // twigs of strips, say
    return of.part == PlantPart::wood && of.evidence.name < 0.0 && of.evidence.flatness > 0.0 && classed.bulks[i] == 0.0 &&
           of.evidence.sum() - of.evidence.name >= kLeafScore;
  };
  const double sum_m2 = area_m2(classed, contradicts);
  if (sum_m2 <= std::max(kMuch * whole_area_m2(classed), leaf_area_m2(classed))) return;
  for (std::size_t i = 0; i < classed.classes.size(); ++i) {
    if (!contradicts(i)) continue;
    PieceClass& of = classed.classes[i];
    of.evidence.name = 0.0;
    judge(of, extent_m);
    of.against_name = true;
    of.reason = "against its name: " + of.reason;
  }
}

/// Makes wood of leaves for which only their form speaks: marks of a bark, splinters.
void judge_marks(ClassedPieces& classed) {
  for (PieceClass& of : classed.classes) {
    if (of.part != PlantPart::leaf || !is_only_form(of)) continue;
    of.part = PlantPart::wood;
    of.reason = "too few and small to be the leaves: " + of.reason;
  }
}

/// For a plant without a crown: makes leaves of the sheets that judge_classes() found too few, too large or too plain (find_leaves.h).
/// Returns whether there are any.
bool judge_sheets(ClassedPieces& classed, NamesOfWood names) {
  // Fewer sheets are a label or the ground, unless they have holes or a telling name.
  constexpr std::uint64_t kSeveral = 3;
  constexpr double kFoliage = 2.0;
  const auto is_sheet = [&](std::size_t i) {
    const PieceClass& of = classed.classes[i];
    const LeafEvidence& evidence = of.evidence;  // all 0 if a rule decided
    const bool is_named = names == NamesOfWood::ignored ? classed.bulks[i] == 0.0 : evidence.name >= 0.0;
    return of.part == PlantPart::wood && evidence.flatness > 0.0 && is_named && classed.bulks[i] < kBody;
  };
  if (names == NamesOfWood::ignored && area_m2(classed, is_sheet) <= kMostly * whole_area_m2(classed)) return false;
  std::map<std::uint32_t, std::uint64_t> sheet_counts;
  for (std::size_t i = 0; i < classed.classes.size(); ++i)
    if (is_sheet(i)) sheet_counts[classed.classes[i].material] += classed.classes[i].piece_count;
  bool any = false;
  for (std::size_t i = 0; i < classed.classes.size(); ++i) {
    PieceClass& of = classed.classes[i];
    if (!is_sheet(i) || (sheet_counts[of.material] < kSeveral && of.evidence.name < kFoliage && of.evidence.holes <= 0.0)) continue;
    of.part = PlantPart::leaf;
    of.against_name = of.evidence.name < 0.0;
    of.reason = "a sheet, and nothing is more like a leaf: " + of.reason;
    any = true;
  }
  return any;
}

std::vector<PieceShape> measure_pieces(const Mesh& mesh, const Pieces& pieces) {
  std::vector<PieceShape> shapes(pieces.ranges.size());
  // Each piece writes its own slot, so the result does not depend on the threads.
  constexpr std::size_t kGrain = 64;
  parallel_for(
      shapes.size(), [&](std::size_t i) { shapes[i] = measure_piece(mesh, pieces.of(i)); }, kGrain);
  return shapes;
}

/// [material] What becomes of its triangles without area: they are dropped if it is foliage.
std::vector<PlantPart> parts_without_area(const std::vector<PieceClass>& classes, const std::vector<Material>& materials,
                                          const std::vector<std::vector<MaterialRule>>& rules) {
  std::vector<std::uint32_t> leaf_counts(materials.size(), 0), other_counts(materials.size(), 0);
  for (const PieceClass& each : classes) (each.part == PlantPart::wood ? other_counts : leaf_counts)[each.material] += each.piece_count;
  std::vector<PlantPart> parts;
  parts.reserve(materials.size());
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const bool unseen = leaf_counts[m] + other_counts[m] == 0;
    const bool foliage = !unseen            ? leaf_counts[m] > other_counts[m]
                         : rules[m].empty() ? name_evidence(materials[m].name) > 0.0
                                            : rules[m].front().part != PlantPart::wood;
    parts.push_back(foliage ? PlantPart::dropped : PlantPart::wood);
  }
  return parts;
}

/// The state of one call.
struct Finder {
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const std::vector<std::vector<MaterialRule>>& rules;
  Mesh mesh;  ///< welded positions are equal
  std::vector<glm::vec3> source_positions;
  std::vector<std::uint32_t> welded;
  Pieces pieces;
  ClassedPieces classed;
  std::vector<PlantPart> without_area;  ///< by material

  [[nodiscard]] std::uint32_t material_of(std::size_t triangle) const { return mesh.triangle_materials[triangle]; }
  [[nodiscard]] std::uint32_t piece_material(std::size_t piece) const { return material_of(pieces.of(piece)[0]); }
  [[nodiscard]] PlantPart piece_part(std::size_t piece) const {
    const std::uint32_t of = classed.class_of[piece];
    return of == kNone ? without_area[piece_material(piece)] : classed.classes[of].part;
  }

  void weld_positions(const std::vector<std::uint32_t>& instances) {
    welded = weld(mesh.positions, instances);
    source_positions = mesh.positions;
    for (std::size_t i = 0; i < welded.size(); ++i) mesh.positions[i] = source_positions[welded[i]];
  }

  /// Makes leaves of sheets if nothing else is a crown; if there are no sheets, of those that grow out of common points.
  void look_for_sheets() {
    if (judge_sheets(classed, NamesOfWood::heeded)) return;
    Pieces whole = std::exchange(pieces, split_surfaces(mesh, welded));
    if (pieces.ranges.size() > whole.ranges.size()) {
      ClassedPieces before = classed;
      judge_pieces();
      if (has_crown(classed) || judge_sheets(classed, NamesOfWood::heeded)) return;
      classed = std::move(before);
    }
    pieces = std::move(whole);
    if (!judge_sheets(classed, NamesOfWood::ignored)) judge_marks(classed);
  }

  /// Groups the pieces by material, triangle and point count.
  /// left_out  [pieces.ranges.size()]
  void class_pieces(const std::vector<PieceShape>& shapes, const std::vector<bool>& left_out) {
    using Key = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
    std::map<Key, std::vector<std::uint32_t>> members;
    for (std::uint32_t i = 0; i < shapes.size(); ++i)
      if (!left_out[i]) members[{piece_material(i), pieces.ranges[i].triangle_count, shapes[i].point_count}].push_back(i);
    std::vector<std::pair<Key, std::vector<std::uint32_t>>> sorted(members.begin(), members.end());
    std::ranges::stable_sort(sorted, [](const auto& a, const auto& b) {
      return std::get<0>(a.first) != std::get<0>(b.first) ? std::get<0>(a.first) < std::get<0>(b.first) : a.second.size() > b.second.size();
    });
    classed = {};
    classed.class_of.assign(shapes.size(), kNone);
    for (const auto& [key, of] : sorted) {
      for (const std::uint32_t i : of) classed.class_of[i] = static_cast<std::uint32_t>(classed.classes.size());
      const auto quantile_of = [&shapes, &list = of](double share, const auto& value) {
        std::vector<double> values;
        values.reserve(list.size());
        for (const std::uint32_t i : list) values.push_back(std::invoke(value, shapes[i]));
        return quantile(std::move(values), share);
      };
      PieceClass made;
      std::tie(made.material, made.triangle_count, made.point_count) = key;
      made.piece_count = static_cast<std::uint32_t>(of.size());
      made.total_triangles = std::uint64_t{made.triangle_count} * made.piece_count;
      made.length_m = quantile_of(0.5, &PieceShape::length_m);
      made.elongation = quantile_of(0.5, &PieceShape::elongation);
      made.flatness = quantile_of(0.5, &PieceShape::flatness);
      made.slenderness = quantile_of(0.5, &PieceShape::slenderness);
      made.low_m = quantile_of(0.02, &PieceShape::low_m);
      made.high_m = quantile_of(0.98, &PieceShape::high_m);
      classed.bulks.push_back(quantile_of(0.5, &PieceShape::bulk));
      classed.areas_m2.push_back(0.0);
      for (const std::uint32_t i : of) classed.areas_m2.back() += shapes[i].area_m2;
      classed.classes.push_back(std::move(made));
    }
  }

  /// Fills in evidence, part and reason of each class, as find_leaves.h says.
  void judge_classes(double extent_m) {
    // Nobody looks at a single one of this many bodies.
    constexpr double kMany = 100.0;
    std::vector<PieceClass>& classes = classed.classes;
    const std::vector<std::vector<std::uint32_t>> samples = sample_classes(pieces, classed);
    const Kin kin(classes);
    for (std::size_t first = 0, last = 0; first < classes.size(); first = last) {
      while (last < classes.size() && classes[last].material == classes[first].material) ++last;
      const std::span<PieceClass> of_material(classes.data() + first, last - first);
      const Material& material = materials[classes[first].material];
      const double name = name_evidence(material.name);
      const bool holes = has_holes(material, images);
      const std::optional<std::size_t> leaves = main_class(of_material);
      for (std::size_t i = 0; i < of_material.size(); ++i) {
        PieceClass& of = of_material[i];
        if (const MaterialRule* rule = fitting_rule(rules[of.material], of.triangle_count)) {
          of.part = rule->part;
          of.reason = rule->source;
          continue;
        }
        of.evidence.name = name;
        of.evidence.holes = holes ? 1.0 : 0.0;
        of.evidence.colour = colour_evidence(mean_color(mesh, samples[first + i], material, images));
        of.evidence.flatness = flatness_evidence(of.flatness, holes);
        const double count = std::max(static_cast<double>(of.piece_count), 0.5 * kin.count(of));
        of.evidence.repetition = repetition_evidence(count);
        if (leaves && i != *leaves) of.evidence.company = company_evidence(of, of_material[*leaves]);
        judge(of, extent_m);
        if (of.part == PlantPart::wood || of.flatness >= kFlat || classed.bulks[first + i] < kBody || count >= kMany) continue;
        // It is a body: a quad would not show it.
        of.part = PlantPart::wood;
        of.is_shell = true;
        of.reason += ", but a body";
      }
    }
    judge_against_names(classed, extent_m);
    judge_what_is_below(classes, extent_m);
  }

  void judge_pieces() {
    const double extent_m = box_diagonal_m(mesh);
    const std::vector<PieceShape> shapes = measure_pieces(mesh, pieces);
    // It is no wider than the weld tolerance: rounding made it, or it fills a T-junction.
    const double tolerance_m = extent_m * static_cast<double>(kWeldTolerance);
    std::vector<bool> left_out(shapes.size());
    for (std::size_t i = 0; i < shapes.size(); ++i)
      left_out[i] = shapes[i].area_m2 <= tolerance_m * std::max(tolerance_m, shapes[i].length_m);
    class_pieces(shapes, left_out);
    judge_classes(extent_m);
  }

  void take_leaves(FoundParts& found) const {
    std::vector<bool> is_leaf(pieces.ranges.size());
    for (std::size_t i = 0; i < is_leaf.size(); ++i) is_leaf[i] = piece_part(i) == PlantPart::leaf;
    const std::vector<std::uint32_t> first_piece = join_materials(mesh, welded, pieces, is_leaf);
    std::vector<std::uint32_t> triangles, leaf_of(mesh.triangle_materials.size());
    for (std::size_t i = 0; i < is_leaf.size(); ++i)
      for (const std::uint32_t t : is_leaf[i] ? pieces.of(i) : TriangleList()) {
        triangles.push_back(t);
        leaf_of[t] = first_piece[i];
      }
    Groups leaves = group_by(triangles, is_leaf.size(), [&](std::uint32_t t) { return leaf_of[t]; });
    found.foliage = mesh_of(leaves.triangles, mesh.positions);
    found.leaves = std::move(leaves.ranges);
  }

  [[nodiscard]] Mesh mesh_of(TriangleList triangles, const std::vector<glm::vec3>& positions) const {
    Mesh part = {positions, mesh.normals, mesh.uvs, {}, {}};
    part.wind_weights = mesh.wind_weights;
    part.vertex_opacities = mesh.vertex_opacities;
    part.vertex_alongs = mesh.vertex_alongs;
    for (const std::uint32_t t : triangles) {
      for (std::size_t k = 0; k < 3; ++k) part.indices.push_back(mesh.indices[3 * std::size_t{t} + k]);
      part.triangle_materials.push_back(mesh.triangle_materials[t]);
      if (!mesh.triangle_tints.empty()) part.triangle_tints.push_back(mesh.triangle_tints[t]);
    }
    return compact(part);
  }

  void take_wood(FoundParts& found) const {
    std::vector<bool> is_wood(mesh.triangle_materials.size(), false);
    for (std::size_t i = 0; i < pieces.ranges.size(); ++i)
      for (const std::uint32_t t : pieces.of(i)) is_wood[t] = piece_part(i) == PlantPart::wood;
    for (std::size_t i = 0; i < pieces.seams.size(); ++i) is_wood[pieces.seams[i]] = piece_part(pieces.seam_pieces[i]) == PlantPart::wood;
    for (const std::uint32_t t : pieces.loose) is_wood[t] = without_area[material_of(t)] == PlantPart::wood;
    std::vector<std::uint32_t> wood;
    for (std::uint32_t t = 0; t < is_wood.size(); ++t)
      if (is_wood[t]) wood.push_back(t);
    found.wood = mesh_of(wood, source_positions);
    found.wood.vertex_opacities.clear();  // only leaves are translucent, or stand for others
    found.wood.vertex_alongs.clear();
    turn_to_normals(found.wood);
  }

  /// Counts dropped leaves without area, and adds a class for them to each material.
  void count_dropped(FoundParts& found) const {
    std::vector<PieceClass> dropped(materials.size());
    for (std::size_t i = 0; i < pieces.ranges.size(); ++i)
      if (classed.class_of[i] == kNone && piece_part(i) == PlantPart::dropped) {
        ++dropped[piece_material(i)].piece_count;
        dropped[piece_material(i)].total_triangles += pieces.ranges[i].triangle_count;
      }
    std::set<std::uint32_t> counted;
    for (std::size_t i = 0; i < pieces.loose.size(); ++i) {
      const std::uint32_t material = material_of(pieces.loose[i]);
      if (without_area[material] != PlantPart::dropped) continue;
      ++dropped[material].total_triangles;
      if (counted.insert(pieces.loose_points[i]).second) ++dropped[material].piece_count;
    }
    for (std::uint32_t m = 0; m < dropped.size(); ++m) {
      if (dropped[m].piece_count == 0) continue;
      found.dropped_leaf_count += dropped[m].piece_count;
      dropped[m].material = m;
      dropped[m].part = PlantPart::dropped;
      dropped[m].reason = "no area";
      found.classes.push_back(std::move(dropped[m]));
    }
    std::ranges::stable_sort(found.classes, {}, [](const PieceClass& each) { return each.material; });
  }
};

}  // namespace

FoundParts find_leaves(TriangleSoup soup, const std::vector<Material>& materials, const std::vector<Image>& images,
                       const std::vector<std::vector<MaterialRule>>& rules) {
  Finder finder{materials, images, rules, std::move(soup.mesh), {}, {}, {}, {}, {}};
  finder.weld_positions(soup.vertex_instances);
  finder.pieces = split_pieces(finder.mesh, finder.welded);
  finder.judge_pieces();
  if (!has_crown(finder.classed)) finder.look_for_sheets();
  finder.without_area = parts_without_area(finder.classed.classes, materials, rules);
  FoundParts found;
  found.has_crown = has_crown(finder.classed);
  finder.take_leaves(found);
  finder.take_wood(found);
  found.classes = std::move(finder.classed.classes);
  finder.count_dropped(found);
  return found;
}

}  // namespace coppice::bake
