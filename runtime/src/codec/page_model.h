#pragma once

// The model that page encoder and decoder share (FORMAT.md, section 9): the contexts that symbols are coded in, the order in which a quad's
// unknown corners are filled, and the prediction for each. It uses integers only, so every reader computes the same.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "coppice/format.h"
#include "tree.h"

namespace coppice::page_model {

using Point = std::array<std::int32_t, 3>;

inline Point point_of(const QuantisedPoint& point) {
  return {point[0], point[1], point[2]};
}

// A split's symbols, in this order; a context is a table of probabilities.
enum Context : std::uint8_t {
  kDeath,     ///< for each child: bit length of the number of splits from its birth to its replacement; 0: it is never replaced
  kChildren,  ///< bit i: parent corner i is a corner of the second child
  kCorners1,  ///< which corners of a child are the parent's; one context for each count ...
  kCorners2,  ///< ... but three contexts for two corners, by their distance in the parent
  kCorners3 = kCorners2 + 3,
  kCorners4,
  kKind,  ///< how the child's new corners are predicted, and whether its card is new; five contexts, by the number of new corners
  kCard = kKind + 5,                 ///< a card that is not the parent's
  kFreeSteps,                        ///< bit lengths of residuals, by Step: five contexts for children of no known shape ...
  kShapedPosition = kFreeSteps + 5,  ///< ... and these for the others
  kShapedDiagonal,
  kShapedFourth,
  kNearFourth,  ///< 9 (x + 1) + 3 (y + 1) + z + 1 of a residual within -1..1, or kFar
  kTurned,      ///< three contexts, by Side
  kParallel = kTurned + 3,
  kOpacity = kParallel + 3,  ///< for a child that is replaced: its opacity less 1, as PageHeader::plain_opacity says
  kSide,                     ///< NormalSide; eight contexts, by side_class. Sides, alongs and axes are a node's normals
  kAlong = kSide + 8,        ///< for a child that is replaced: as PageHeader::plain_along says
  kLeafAlong,                ///< for a source leaf
  kAxis,                     ///< u, then v, less the guess of PageHeader::axis_rules; four contexts, by axis_class
  kContextCount = kAxis + 4
};
enum Side : std::uint8_t { kFirstSide, kSecondSide, kSquareAxis };
inline constexpr std::uint32_t kFar = 27;

/// Number of symbols of each context; kCard's are the plant's cards.
inline constexpr std::array<std::uint16_t, kContextCount> kAlphabet = {28, 16, 4,  12, 12, 12, 24, 24, 18, 18, 18, 18, 2,  256, 17,
                                                                       17, 17, 17, 17, 17, 17, 17, 28, 17, 17, 17, 17, 17, 17,  16,
                                                                       4,  4,  4,  4,  4,  4,  4,  4,  16, 16, 8,  16, 32, 32};
inline constexpr std::size_t kSymbolCount = [] {
  std::size_t sum = 0;
  for (std::uint16_t symbols : kAlphabet) sum += symbols;
  return sum;
}();
/// Bytes of the mask that says which contexts' tables a page stores.
inline constexpr std::size_t kStoredBytes = (kContextCount + 7) / 8;
/// Maximum of plain bits of a split: two numbers of at most 27 bits, and three residuals of 16 bits for each of four corners. The symbol
/// holds the highest bit of each.
inline constexpr std::uint32_t kMaxPlainBits = 2 * 26 + 4 * 3 * 15;

/// Default weights of the symbols, one hexadecimal digit a symbol (symbol_weight). Measured over the trees of 13 plants. A page may give
/// its own.
extern const std::array<const char*, kContextCount> kDefaultWeights;

// Kinds of children: free, then for each shape turned and parallel.
inline constexpr std::uint32_t kFree = 0;
inline constexpr std::uint32_t kParallelogramIndex = 0;  // index of kParallelogram among shapes
inline constexpr std::uint32_t kMaxShapes = 4;
constexpr std::uint32_t shape_of(std::uint32_t kind) {
  return (kind - 1) / 2;
}
constexpr bool is_parallel(std::uint32_t kind) {
  return kind != kFree && kind % 2 == 0;
}

/// Corner 3 is corner 0 + (a (corner 1 - corner 0) + b (corner 2 - corner 0)) / kShapeOne.
struct Shape {
  std::int16_t a = 0, b = 0;
  bool operator==(const Shape&) const = default;
};
inline constexpr std::int32_t kShapeOne = 4096;
inline constexpr Shape kParallelogram{-kShapeOne, kShapeOne};

/// From what the axis of a child's normals is guessed.
enum class AxisRule : std::uint8_t {
  parent,  ///< the parent's axis
  quad,    ///< the normal of the child's quad
  spine,   ///< the direction of the child's quad from stalk to tip
  plain,   ///< nothing
};
inline constexpr std::uint32_t kAxisRules = 4, kAxisClasses = 4;

/// Values that a page states once.
struct PageHeader {
  std::uint32_t split_count = 0;
  std::uint32_t shape_count = 1;
  std::array<Shape, kMaxShapes> shapes{kParallelogram};
  bool plain_opacity = false, plain_along = false;     ///< true if coded directly, else as a difference to the parent's
  std::array<AxisRule, kAxisClasses> axis_rules{};     ///< by axis_class
  bool leaf_normals = false;                           ///< source leaves have normals, too, else they are kFlatNormals
  std::array<std::uint16_t, 3> axis_weights{};         ///< squared length of a step along each axis, to a common scale
  std::int32_t quantised_max = COPPICE_QUANTISED_MAX;  ///< the plant's; not in the page
};

// How a corner is predicted, by the corners of the quad that are known already.
enum class Rule : std::uint8_t {
  position,  ///< from no corner
  first,     ///< from one neighbour
  second,    ///< from one neighbour and the corner on its other side
  diagonal,  ///< from both neighbours
  fourth,    ///< from all other corners
};
struct Step {
  Rule rule = Rule::position;
  std::uint8_t corner = 0;
  std::uint8_t neighbour = 0;  ///< a neighbour that is known
};
struct Steps {
  std::array<Step, 4> step{};
  std::uint32_t count = 0;
};

constexpr Steps steps_from(unsigned known) {
  Steps steps;
  while (known != 15) {
    Step& step = steps.step[steps.count++];
    const int known_count = std::popcount(known);
    const auto is_known = [&](unsigned corner) { return (known >> (corner & 3) & 1) != 0; };
    unsigned corner = static_cast<unsigned>(std::countr_one(known));
    if (known_count == 1) corner = (static_cast<unsigned>(std::countr_zero(known)) + 1) & 3;
    step.neighbour = static_cast<std::uint8_t>((corner + (is_known(corner + 1) && known_count != 1 ? 1 : 3)) & 3);
    if (known_count == 0) step.rule = Rule::position;
    if (known_count == 1) step.rule = Rule::first;
    if (known_count == 2) step.rule = is_known(corner + 1) && is_known(corner + 3) ? Rule::diagonal : Rule::second;
    if (known_count == 3) step.rule = Rule::fourth;
    step.corner = static_cast<std::uint8_t>(corner);
    known |= 1u << corner;
  }
  return steps;
}

/// Indexed by the known corners, bit i for corner i.
inline constexpr std::array<Steps, 16> kSteps = [] {
  std::array<Steps, 16> all{};
  for (unsigned known = 0; known < 16; ++known) all[known] = steps_from(known);
  return all;
}();

/// Which context codes a side.
constexpr std::size_t side_class(bool is_source, NormalSide parent) {
  return (is_source ? 4 : 0) + static_cast<std::size_t>(parent);
}

/// Which context codes an axis: one for each number of bits, and one for source leaves.
constexpr std::size_t axis_class(bool is_source, std::uint32_t along_step) {
  return is_source ? kAxisClasses - 1 : axis_bits(along_step) - 3;
}

/// Number of set bits in each number of four bits; not every target processor has an instruction for it.
inline constexpr std::array<std::uint8_t, 16> kBitCount = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};

/// The four corners of a child that a symbol of kCorners1..4 stands for, relative to the first: symbol % 6.
inline constexpr std::array<std::array<std::uint8_t, 4>, 6> kCornerOrders = {
    {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 1, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {0, 3, 2, 1}}};

/// A parent, and values computed from it once.
struct Parent {
  std::array<Point, 4> corners{};
  Point centre{};
};
inline Parent parent_of(const QuantisedQuad& quad) {
  Parent parent;
  for (std::size_t i = 0; i < 4; ++i) parent.corners[i] = point_of(quad[i]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t sum = parent.corners[0][axis] + parent.corners[1][axis] + parent.corners[2][axis] + parent.corners[3][axis];
    parent.centre[axis] = (sum + 2) >> 2;
  }
  return parent;
}

inline Point difference(const Point& to, const Point& from) {
  return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

inline std::int32_t clamp_coordinate(const PageHeader& header, std::int64_t value) {
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(value, 0, header.quantised_max));
}

/// Predicts the corner of `step`.
/// quad  the corners known so far
Point predict(const PageHeader& header, std::uint32_t kind, const Step& step, const std::array<Point, 4>& quad, const Parent& parent);

/// Guesses u and v of a child's axis, of so many bits.
std::array<std::uint32_t, 2> guess_axis(const PageHeader& header, AxisRule rule, std::uint32_t bits, const std::array<Point, 4>& quad,
                                        std::uint16_t parent_normals);

/// The axis along which a right angle to the first side gives a child's second side, or 3 if there is none.
/// along  the known side
std::size_t square_axis(const PageHeader& header, const Point& along);

/// Computes that coordinate of the second side from its other two.
std::int32_t square_coordinate(const PageHeader& header, const Point& along, const Point& side, std::size_t axis);

}  // namespace coppice::page_model

namespace coppice {

/// Scratch memory for decoding a page, besides Draco's decoders. Some 10 KiB: kept off the stacks of an engine's jobs.
struct PageScratch {
  std::array<std::uint32_t, COPPICE_PAGE_SPLITS> parents;     ///< parents of the page's splits
  std::array<std::uint64_t, 2 * COPPICE_PAGE_SPLITS> deaths;  ///< the splits that replace its nodes, above their places
};

}  // namespace coppice
