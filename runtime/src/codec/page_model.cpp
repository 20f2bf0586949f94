#include "page_model.h"

#include <algorithm>
#include <cstdlib>

namespace coppice::page_model {

namespace {

/// Weights of known values, relative to a base, times 64.
struct Weights {
  std::int32_t other, own, third, centre;
};

// Indexed by Rule. Measured: least absolute residual over the trees of 13 plants.
constexpr std::array<Weights, 5> kFreeWeights = {{{0, 12, 0, 0}, {0, 5, 0, 34}, {-18, 8, -2, 55}, {8, 6, 0, 41}, {17, 8, -24, 39}}};
constexpr std::array<Weights, 4> kShapedWeights = {{{0, 38, 0, 0}, {0, 23, -7, 22}, {-28, 6, -7, 58}, {27, 46, 0, -37}}};

/// Nearest integer to n / d, the larger of two at a tie. d != 0.
std::int64_t rounded_quotient(std::int64_t n, std::int64_t d) {
  if (d < 0) {
    n = -n;
    d = -d;
  }
  n += d / 2;
  return n >= 0 ? n / d : -((-n + d - 1) / d);
}

/// The largest integer whose square is at most `square`.
std::int64_t integer_root(std::uint32_t square) {
  std::uint32_t root = 0;
  for (std::uint32_t bit = 1u << 15; bit != 0; bit >>= 1)
    if (std::uint64_t{root | bit} * (root | bit) <= square) root |= bit;
  return root;
}

Point fourth_of_shape(const PageHeader& header, std::uint32_t kind, const std::array<Point, 4>& quad, std::size_t corner) {
  const Shape& shape = header.shapes[shape_of(kind)];
  const std::array<std::int64_t, 4> factors = {std::int64_t{shape.a} + shape.b - kShapeOne, -shape.a, -shape.b, kShapeOne};
  Point guess = quad[(corner + 1) & 3];
  if (factors[corner] == 0) return guess;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (i != corner) sum -= factors[i] * quad[i][axis];
    guess[axis] = clamp_coordinate(header, rounded_quotient(sum, factors[corner]));
  }
  return guess;
}

Point parallelogram(const PageHeader& header, const Point& one, const Point& other, const Point& across) {
  Point guess{};
  for (std::size_t axis = 0; axis < 3; ++axis) guess[axis] = clamp_coordinate(header, one[axis] + other[axis] - across[axis]);
  return guess;
}

using Direction = std::array<std::int64_t, 3>;

/// A step along an axis is the root of its weight long, so that each coordinate of the cross product of the diagonals has the roots of two
/// weights as a factor: below 2^31 times 2^16.
Direction normal_of(const PageHeader& header, const std::array<Point, 4>& quad) {
  const Point d = difference(quad[2], quad[0]), e = difference(quad[3], quad[1]);
  Direction normal{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t next = (axis + 1) % 3, last = (axis + 2) % 3;
    const std::int64_t factor = integer_root(std::uint32_t{header.axis_weights[next]} * header.axis_weights[last]);
    normal[axis] = factor * (std::int64_t{d[next]} * e[last] - std::int64_t{d[last]} * e[next]);
  }
  return normal;
}

/// From the middle of corners 0 and 3 to that of 1 and 2.
Direction spine_of(const PageHeader& header, const std::array<Point, 4>& quad) {
  Direction spine{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    spine[axis] = integer_root(65535u * header.axis_weights[axis]) * (quad[1][axis] + quad[2][axis] - quad[0][axis] - quad[3][axis]);
  return spine;
}

/// u and v, of so many bits, of a direction or its opposite.
std::array<std::uint32_t, 2> axis_along(const Direction& direction, std::uint32_t bits) {
  const auto& [x, y, z] = direction;
  const std::int64_t length = std::max<std::int64_t>(1, std::abs(x) + std::abs(y) + std::abs(z));  // no direction: straight up
  const std::int64_t sign = y < 0 || (y == 0 && x < 0) ? -1 : 1, half = 1 << (bits - 1);
  const auto step = [&](std::int64_t share) {
    return static_cast<std::uint32_t>(half + rounded_quotient(sign * share * (half - 1), length));
  };
  return {step(x + z), step(x - z)};
}

}  // namespace

Point predict(const PageHeader& header, std::uint32_t kind, const Step& step, const std::array<Point, 4>& quad, const Parent& parent) {
  const std::size_t corner = step.corner;
  const Point &own = parent.corners[corner], &across = quad[(corner + 2) & 3], &opposite = quad[(corner + 3) & 3];
  const bool by_side = step.rule == Rule::first || step.rule == Rule::second;
  if (kind != kFree && step.rule == Rule::fourth) {
    if (shape_of(kind) == kParallelogramIndex) return parallelogram(header, quad[(corner + 1) & 3], opposite, across);
    return fourth_of_shape(header, kind, quad, corner);
  }
  if (is_parallel(kind) && by_side) return parallelogram(header, quad[step.neighbour], own, parent.corners[step.neighbour]);
  const Weights& weights = (kind == kFree ? kFreeWeights.data() : kShapedWeights.data())[static_cast<std::size_t>(step.rule)];
  const Point& base = step.rule == Rule::position ? parent.centre : quad[step.neighbour];
  const Point& other = step.rule == Rule::second ? across : opposite;
  const Point& third = by_side ? parent.corners[step.neighbour] : across;
  Point guess{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int32_t sum = weights.other * (other[axis] - base[axis]) + weights.own * (own[axis] - base[axis]) +
                             weights.third * (third[axis] - base[axis]) + weights.centre * (parent.centre[axis] - base[axis]);
    guess[axis] = clamp_coordinate(header, base[axis] + ((sum + 32) >> 6));
  }
  return guess;
}

std::array<std::uint32_t, 2> guess_axis(const PageHeader& header, AxisRule rule, std::uint32_t bits, const std::array<Point, 4>& quad,
                                        std::uint16_t parent_normals) {
  switch (rule) {
    case AxisRule::parent: {
      const std::uint32_t steps = (1u << bits) - 1;
      const auto step = [&](std::size_t which) {
        return (2 * axis_step_of(parent_normals, which) * steps + kAxisSteps) / (2 * kAxisSteps);
      };
      return {step(0), step(1)};
    }
    case AxisRule::quad:
      return axis_along(normal_of(header, quad), bits);
    case AxisRule::spine:
      return axis_along(spine_of(header, quad), bits);
    case AxisRule::plain:
      break;
  }
  return {0, 0};
}

std::size_t square_axis(const PageHeader& header, const Point& along) {
  std::size_t best = 3;
  std::int64_t longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t length = std::int64_t{along[axis] < 0 ? -along[axis] : along[axis]} * header.axis_weights[axis];
    if (length <= longest) continue;
    longest = length;
    best = axis;
  }
  return best;
}

std::int32_t square_coordinate(const PageHeader& header, const Point& along, const Point& side, std::size_t axis) {
  std::int64_t product = 0;
  for (std::size_t other = 0; other < 3; ++other)
    if (other != axis) product += std::int64_t{along[other]} * side[other] * header.axis_weights[other];
  const std::int64_t value = rounded_quotient(-product, std::int64_t{along[axis]} * header.axis_weights[axis]);
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(value, -(1 << 15), 1 << 15));
}

const std::array<const char*, kContextCount> kDefaultWeights = {
    "fa42356789aa9876543211111111",
    "d79c95ecbc4aeccf",
    "fede",
    "f7996c969a6c",
    "8f88d56765c4",
    "b9fb5bb6ce5c",
    "fc9d4885757953243664889a",
    "f12111111125111111111116",
    "b7fed8621123111211",
    "fcfdca612143212121",
    "fafcc8134124411221",
    "f4d611611121112111",
    "f2",
    "1",
    "112468aceffeb621",
    "1123579bdeffc941",
    "112368acdffec841",
    "1122479bdeffda31",
    "112468acdffec951",
    "33579bceffec7111",
    "24469bdefeec6111",
    "eceffdecbba82111",
    "3737b73737b7bfb7b73747b7373e",
    "22468acdeffd8111",
    "22468acefffc6111",
    "fcd9544321111111",
    "fdddcdefffed6221",
    "ecefdcbedb9a5211",
    "fcd8763111111111",
    "1",
    "1",
    "01",
    "001",
    "0001",
    "1",
    "01",
    "001",
    "0001",
    "fdba98767776657b",
    "0000000000000001",
    "fc9aba9c",
    "fda87788887768ad",
    "fc97432111111111111111111123569c",
    "f741111213121137",
};

}  // namespace coppice::page_model
