// Encodes a page (FORMAT.md, section 9; page_model.h). The encoder chooses the kind of each child and the tables. They depend on each
// other, so it plans the page a few times, each time with the symbol costs of the last.

#include "page_encode.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>

#include "check.h"
#include "symbol_writer.h"

namespace coppice::bake {
namespace {

using page_model::Context;
using page_model::PageHeader;
using page_model::Parent;
using page_model::Point;
using page_model::Shape;
using page_model::Step;

struct Affine {
  double a = 0.0, b = 0.0;
};

bool near(const Affine& one, const Affine& other) {
  constexpr double kSame = 0.03;
  return std::abs(one.a - other.a) < kSame && std::abs(one.b - other.b) < kSame;
}

double dot(const Point& u, const Point& v) {
  return double(u[0]) * v[0] + double(u[1]) * v[1] + double(u[2]) * v[2];
}

/// Corner 3 by least squares from the other three, in steps of the box. Empty for a parallelogram, a sliver, and values that a Shape cannot
/// hold.
std::optional<Affine> affine_of(const QuantisedQuad& quad) {
  constexpr double kLargest = 7.9, kSliver = 1e-6;
  constexpr std::int32_t kRounding = 3;
  std::array<Point, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = page_model::point_of(quad[i]);
  const Point e = page_model::difference(corners[1], corners[0]), f = page_model::difference(corners[2], corners[0]);
  const Point g = page_model::difference(corners[3], corners[0]);
  bool parallelogram = true;
  for (std::size_t axis = 0; axis < 3; ++axis) parallelogram = parallelogram && std::abs(g[axis] - f[axis] + e[axis]) <= kRounding;
  const double determinant = dot(e, e) * dot(f, f) - dot(e, f) * dot(e, f);
  if (parallelogram || determinant <= kSliver * dot(e, e) * dot(f, f)) return {};
  const Affine affine{(dot(g, e) * dot(f, f) - dot(g, f) * dot(e, f)) / determinant,
                      (dot(g, f) * dot(e, e) - dot(g, e) * dot(e, f)) / determinant};
  if (std::abs(affine.a) > kLargest || std::abs(affine.b) > kLargest) return {};
  return affine;
}

/// Removes the largest cluster of `affines` and returns its mean; empty if it has fewer members than `min_count`.
std::optional<Affine> take_cluster(std::vector<Affine>& affines, std::size_t min_count) {
  const Affine* centre = nullptr;
  std::ptrdiff_t largest = 0;
  for (const Affine& candidate : affines) {
    const auto count = std::ranges::count_if(affines, [&](const Affine& affine) { return near(affine, candidate); });
    if (count <= largest) continue;
    largest = count;
    centre = &candidate;
  }
  if (centre == nullptr || static_cast<std::size_t>(largest) < min_count) return {};
  const auto others =
      std::stable_partition(affines.begin(), affines.end(), [middle = *centre](const Affine& affine) { return near(affine, middle); });
  Affine sum;
  for (const Affine& affine : std::span(affines.begin(), others)) sum.a += affine.a, sum.b += affine.b;
  affines.erase(affines.begin(), others);
  return Affine{sum.a / static_cast<double>(largest), sum.b / static_cast<double>(largest)};
}

std::int16_t fixed_point(double value) {
  return static_cast<std::int16_t>(std::lround(value * page_model::kShapeOne));
}

struct SymbolCode {
  std::uint8_t context, symbol;
};

struct Codes {
  std::vector<SymbolCode> symbols;
  std::vector<PlainBits> bits;

  void clear() {
    symbols.clear();
    bits.clear();
  }
  void append(const Codes& other) {
    symbols.insert(symbols.end(), other.symbols.begin(), other.symbols.end());
    bits.insert(bits.end(), other.bits.begin(), other.bits.end());
  }
  void symbol(std::size_t context, std::uint32_t value) {
    COPPICE_ASSERT(value < page_model::kAlphabet[context]);
    symbols.push_back({static_cast<std::uint8_t>(context), static_cast<std::uint8_t>(value)});
  }
  /// Adds all bits of a number but the highest, whose place a symbol tells.
  void low_bits(std::uint32_t value) {
    const auto length = static_cast<std::uint32_t>(std::bit_width(value));
    if (length > 1) bits.push_back({value - (1u << (length - 1)), length - 1});
  }
};

/// Probabilities of one context, as a page stores them.
struct Table {
  std::vector<std::uint8_t> digits;
  std::vector<std::uint32_t> probabilities;
  std::vector<double> costs;  ///< bits

  /// Whether the context has only one symbol, which takes no bytes.
  [[nodiscard]] bool only_one() const { return std::ranges::count(probabilities, kProbabilityOne) > 0; }
};
using Tables = std::array<Table, Context::kContextCount>;

Table table_of(std::vector<std::uint8_t> digits) {
  Table table{std::move(digits), {}, {}};
  table.probabilities.resize(table.digits.size());
  share_out(table.digits, table.probabilities);
  table.costs = symbol_costs(table.probabilities);
  return table;
}

Tables default_tables() {
  Tables tables;
  for (std::size_t context = 0; context < Context::kContextCount; ++context) {
    std::vector<std::uint8_t> digits;
    for (const char* digit = page_model::kDefaultWeights[context]; *digit != 0; ++digit)
      digits.push_back(static_cast<std::uint8_t>(*digit <= '9' ? *digit - '0' : *digit - 'a' + 10));
    tables[context] = table_of(std::move(digits));
  }
  return tables;
}

/// Bits of a part of the page. A symbol that the table lacks costs more than any that it has, so that it can come into use.
double cost_of(const Codes& codes, const Tables& tables) {
  constexpr double kUnseen = 12.0;
  double sum = 0.0;
  for (const SymbolCode& code : codes.symbols) {
    const std::vector<double>& costs = tables[code.context].costs;
    sum += code.symbol < costs.size() ? std::min(costs[code.symbol], kUnseen) : kUnseen;
  }
  for (const PlainBits& plain : codes.bits) sum += plain.count;
  return sum;
}

std::array<std::uint16_t, 3> axis_weights(const glm::vec3& extent) {
  const double longest = std::max({extent.x, extent.y, extent.z});
  std::array<std::uint16_t, 3> weights{};
  for (int axis = 0; axis < 3 && longest > 0.0; ++axis) {
    const double share = extent[axis] / longest;
    weights[static_cast<std::size_t>(axis)] = static_cast<std::uint16_t>(std::lround(share * share * 65535.0));
  }
  return weights;
}

struct Child {
  std::array<Point, 4> corners{};
  unsigned known = 0;
  std::uint32_t card = 0;
};

std::array<Child, 2> children_of(const Split& split, const QuantisedQuad& parent) {
  const ChildQuads quads = child_quads(parent, split);
  std::array<Child, 2> children;
  for (std::size_t c = 0; c < 2; ++c) {
    for (std::size_t corner = 0; corner < 4; ++corner)
      children[c].corners[corner] = page_model::point_of((c == 0 ? quads.first : quads.second)[corner]);
    children[c].card = split.cards[c];
  }
  for (std::uint8_t slot : split.parent_slots) children[slot / 4].known |= 1u << slot % 4;
  COPPICE_ASSERT(std::popcount(children[0].known) + std::popcount(children[1].known) == 4);
  return children;
}

/// Codes which corners of child `c` are the parent's.
void code_corners(const std::array<std::uint8_t, 4>& slots, unsigned c, Codes& codes) {
  std::array<unsigned, 4> at{}, corner{};  // in the parent, in the child
  std::size_t count = 0;
  for (unsigned i = 0; i < 4; ++i) {
    if (slots[i] / 4 != c) continue;
    at[count] = i;
    corner[count++] = slots[i] % 4u;
  }
  if (count == 0) return;
  const unsigned turn = (corner[0] - at[0]) & 3;
  if (count == 1) return codes.symbol(Context::kCorners1, turn);
  const unsigned second = (corner[1] - corner[0]) & 3;
  if (count == 2) return codes.symbol(Context::kCorners2 + at[1] - at[0] - 1, 3 * turn + second - 1);
  const unsigned third = (corner[2] - corner[0]) & 3;
  const unsigned lower_left = second == 1 ? 2 : 1;  // the smaller corner that the third can be
  codes.symbol(count == 3 ? Context::kCorners3 : Context::kCorners4, 6 * turn + 2 * (second - 1) + (third == lower_left ? 0 : 1));
}

/// Codes how a child shows, from its parent: opacity and normals.
void code_look(const PageNode& child, const PageNode& parent, const PageHeader& header, Codes& codes) {
  const bool is_source = child.split == kNeverReplaced;
  if (!is_source) codes.symbol(Context::kOpacity, (child.opacity + kOpaque - (header.plain_opacity ? 1u : parent.opacity)) % kOpaque);
  if (is_source && !header.leaf_normals) return;
  const NormalSide side = side_of(child.normals);
  codes.symbol(Context::kSide + page_model::side_class(is_source, side_of(parent.normals)), static_cast<std::uint32_t>(side));
  if (side == NormalSide::own_quad) return;
  const std::uint32_t along = along_step_of(child.normals);
  const std::uint32_t from = is_source || header.plain_along ? 0 : along_step_of(parent.normals);
  codes.symbol(is_source ? Context::kLeafAlong : Context::kAlong, (along - from) & kAlongSteps);
  const std::size_t axis = page_model::axis_class(is_source, along);
  const std::uint32_t bits = axis_bits(along), mask = (1u << bits) - 1;
  std::array<Point, 4> corners;
  std::ranges::transform(child.corners, corners.begin(), page_model::point_of);
  const std::array<std::uint32_t, 2> guess = page_model::guess_axis(header, header.axis_rules[axis], bits, corners, parent.normals);
  for (std::size_t i = 0; i < 2; ++i)
    codes.symbol(Context::kAxis + axis, ((axis_step_of(child.normals, i) >> (kAxisBits - bits)) - guess[i]) & mask);
}

/// Codes residuals of three axes: their bit lengths in the given contexts, then their bits below the highest.
void code_values(const std::array<std::int32_t, 3>& values, const std::array<std::size_t, 3>& contexts, Codes& codes) {
  for (std::size_t i = 0; i < 3; ++i) codes.symbol(contexts[i], static_cast<std::uint32_t>(std::bit_width(zigzag(values[i]))));
  for (std::int32_t value : values) codes.low_bits(zigzag(value));
}

class Planner {
 public:
  Planner(const PageSource& source, PageHeader header) : source_(source), header_(header) {}

  /// The page's codes, with the kinds that are cheapest under `tables`.
  Codes plan(const Tables& tables) {
    Codes codes;
    for (std::uint32_t i = 0; i < source_.splits.size(); ++i) code_split(source_.first_split + i, source_.splits[i], tables, codes);
    return codes;
  }

 private:
  void code_split(std::uint32_t index, const Split& split, const Tables& tables, Codes& codes) {
    COPPICE_ASSERT(split.parent <= 2 * index);
    for (std::uint32_t child = 2 * index + 1; child <= 2 * index + 2; ++child) {
      const std::uint32_t death = source_.nodes[child].split;
      const std::uint32_t lifetime = death == kNeverReplaced ? 0 : death - index;
      codes.symbol(Context::kDeath, static_cast<std::uint32_t>(std::bit_width(lifetime)));
      codes.low_bits(lifetime);
    }
    const PageNode& parent_node = source_.nodes[split.parent];
    const std::array<Child, 2> children = children_of(split, parent_node.corners);
    std::uint32_t pattern = 0;
    for (unsigned i = 0; i < 4; ++i) pattern |= (split.parent_slots[i] / 4u) << i;
    codes.symbol(Context::kChildren, pattern);
    code_corners(split.parent_slots, 0, codes);
    code_corners(split.parent_slots, 1, codes);
    const Parent parent = page_model::parent_of(parent_node.corners);
    const std::size_t fuller = std::popcount(pattern) > 2 ? 1 : 0;
    for (std::size_t c : {fuller, 1 - fuller}) code_child(children[c], parent_node.card, parent, tables, codes);
    for (std::uint32_t child = 2 * index + 1; child <= 2 * index + 2; ++child) code_look(source_.nodes[child], parent_node, header_, codes);
  }

  void code_child(const Child& child, std::uint32_t parent_card, const Parent& parent, const Tables& tables, Codes& codes) {
    const std::uint32_t kind_count = child.known == 15 ? 1 : 1 + 2 * header_.shape_count;
    double lowest = 0.0;
    for (std::uint32_t kind = 0; kind < kind_count; ++kind) {
      trial_.clear();
      const bool new_card = child.card != parent_card;
      trial_.symbol(Context::kKind + static_cast<std::size_t>(std::popcount(child.known)), 2 * kind + (new_card ? 1 : 0));
      if (new_card) trial_.symbol(Context::kCard, child.card);
      const page_model::Steps& steps = page_model::kSteps[child.known];
      for (std::uint32_t s = 0; s < steps.count; ++s) code_corner(kind, steps.step[s], child.corners, parent, trial_);
      const double cost = cost_of(trial_, tables);
      if (kind > 0 && cost >= lowest) continue;
      lowest = cost;
      std::swap(best_, trial_);
    }
    codes.append(best_);
  }

  void code_corner(std::uint32_t kind, const Step& step, const std::array<Point, 4>& corners, const Parent& parent, Codes& codes) const {
    const Point guess = page_model::predict(header_, kind, step, corners, parent);
    const Point residual = page_model::difference(corners[step.corner], guess);
    const auto code_all = [&](std::size_t context) { code_values(residual, {context, context, context}, codes); };
    if (kind == page_model::kFree) return code_all(Context::kFreeSteps + static_cast<std::size_t>(step.rule));
    const std::size_t side = side_of(kind);
    switch (step.rule) {
      case page_model::Rule::position:
        return code_all(Context::kShapedPosition);
      case page_model::Rule::first:
        return code_all(side + page_model::kFirstSide);
      case page_model::Rule::second:
        return code_second_side(kind, step, corners, residual, codes);
      case page_model::Rule::diagonal:
        return code_all(Context::kShapedDiagonal);
      case page_model::Rule::fourth:
        break;
    }
    std::uint32_t near = 0;
    bool is_near = true;
    for (std::int32_t value : residual) {
      near = 3 * near + static_cast<std::uint32_t>(value + 1);
      is_near = is_near && value >= -1 && value <= 1;
    }
    codes.symbol(Context::kNearFourth, is_near ? near : page_model::kFar);
    if (!is_near) code_all(Context::kShapedFourth);
  }

  static std::size_t side_of(std::uint32_t kind) { return page_model::is_parallel(kind) ? Context::kParallel : Context::kTurned; }

  void code_second_side(std::uint32_t kind, const Step& step, const std::array<Point, 4>& corners, const Point& residual,
                        Codes& codes) const {
    const std::size_t side = side_of(kind);
    const std::size_t free = side + page_model::kSecondSide;
    const Point &base = corners[step.neighbour], &corner = corners[step.corner];
    const Point along = page_model::difference(corners[(step.corner + 2) & 3], base);
    const std::size_t axis = page_model::shape_of(kind) == page_model::kParallelogramIndex ? page_model::square_axis(header_, along) : 3;
    if (axis == 3) return code_values(residual, {free, free, free}, codes);
    const std::int32_t value = page_model::square_coordinate(header_, along, page_model::difference(corner, base), axis);
    const std::int32_t off = corner[axis] - page_model::clamp_coordinate(header_, base[axis] + value);
    code_values({residual[(axis + 1) % 3], residual[(axis + 2) % 3], off}, {free, free, side + page_model::kSquareAxis}, codes);
  }

  const PageSource& source_;
  PageHeader header_;
  Codes trial_, best_;
};

std::array<std::vector<std::uint32_t>, Context::kContextCount> count_symbols(const Codes& codes) {
  std::array<std::vector<std::uint32_t>, Context::kContextCount> counts;
  for (const SymbolCode& code : codes.symbols) {
    std::vector<std::uint32_t>& of = counts[code.context];
    if (of.size() <= code.symbol) of.resize(code.symbol + std::size_t{1});
    ++of[code.symbol];
  }
  return counts;
}

/// Bits of one context's symbols; infinite if the table lacks one.
double cost_of(const std::vector<std::uint32_t>& counts, const std::vector<double>& costs) {
  double sum = 0.0;
  for (std::size_t symbol = 0; symbol < counts.size(); ++symbol)
    if (counts[symbol] > 0) sum += symbol < costs.size() ? counts[symbol] * costs[symbol] : HUGE_VAL;
  return sum;
}

/// Bits of one context's symbols with a table of their own, and of that table.
double own_cost_of(const std::vector<std::uint32_t>& counts) {
  const std::size_t table_bytes = 1 + (counts.size() + 1) / 2;
  return cost_of(counts, table_of(weight_digits(counts)).costs) + 8.0 * static_cast<double>(table_bytes);
}

/// Chooses tables for `codes`. Returns which of them the page stores, a bit a context.
std::uint64_t choose_tables(const Codes& codes, const Tables& usual, std::uint32_t kind_symbols, Tables& tables) {
  std::uint64_t stored = 0;
  const auto counts = count_symbols(codes);
  for (std::size_t context = 0; context < counts.size(); ++context) {
    const bool kinds = context >= Context::kKind && context < Context::kKind + 4;
    std::vector<std::uint8_t> digits = usual[context].digits;
    if (kinds && digits.size() > kind_symbols) digits.resize(kind_symbols);
    tables[context] = table_of(std::move(digits));
    if (counts[context].empty()) continue;
    if (own_cost_of(counts[context]) >= cost_of(counts[context], tables[context].costs)) continue;
    tables[context] = table_of(weight_digits(counts[context]));
    stored |= std::uint64_t{1} << context;
  }
  return stored;
}

void put(std::vector<std::uint8_t>& bytes, std::uint64_t value, std::size_t byte_count) {
  for (std::size_t i = 0; i < byte_count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

void put_header(const PageHeader& header, std::vector<std::uint8_t>& bytes) {
  put(bytes, header.split_count, 2);
  put(bytes, header.shape_count - 1, 1);
  std::uint32_t rules = (header.plain_opacity ? 1u : 0u) | (header.plain_along ? 2u : 0u) | (header.leaf_normals ? 4u : 0u);
  for (std::size_t i = 0; i < header.axis_rules.size(); ++i) rules |= static_cast<std::uint32_t>(header.axis_rules[i]) << (3 + 2 * i);
  put(bytes, rules, 2);
  for (std::uint16_t weight : header.axis_weights) put(bytes, weight, 2);
  for (std::size_t i = 1; i < header.shape_count; ++i) {
    put(bytes, static_cast<std::uint16_t>(header.shapes[i].a), 2);
    put(bytes, static_cast<std::uint16_t>(header.shapes[i].b), 2);
  }
}

void put_tables(const Tables& tables, std::uint64_t stored, std::vector<std::uint8_t>& bytes) {
  put(bytes, stored, page_model::kStoredBytes);
  for (std::size_t context = 0; context < Context::kContextCount; ++context) {
    if ((stored >> context & 1) == 0) continue;
    const std::vector<std::uint8_t>& digits = tables[context].digits;
    put(bytes, static_cast<std::uint32_t>(digits.size() - 1), 1);
    for (std::size_t i = 0; i < digits.size(); i += 2) {
      const std::uint32_t high = i + 1 < digits.size() ? digits[i + 1] : 0u;
      put(bytes, digits[i] | high << 4, 1);
    }
  }
}

/// Writes seven bits a byte, the lowest first.
void put_length(std::vector<std::uint8_t>& bytes, std::size_t length) {
  for (; length > 127; length >>= 7) bytes.push_back(static_cast<std::uint8_t>(length | 128));
  bytes.push_back(static_cast<std::uint8_t>(length));
}

void put_codes(const Codes& codes, const Tables& tables, std::vector<std::uint8_t>& bytes) {
  std::array<std::vector<std::uint8_t>, Context::kContextCount> symbols;
  for (const SymbolCode& code : codes.symbols) symbols[code.context].push_back(code.symbol);
  for (std::size_t context = 0; context < symbols.size(); ++context) {
    const std::vector<std::uint8_t> block = write_symbols(tables[context].probabilities, symbols[context]);
    if (!tables[context].only_one()) put_length(bytes, block.size());
    bytes.insert(bytes.end(), block.begin(), block.end());
  }
  const std::vector<std::uint8_t> rest = write_bits(codes.bits);
  bytes.insert(bytes.end(), rest.begin(), rest.end());
}

/// Chooses how opacities and normals are guessed: whatever takes the fewest bits in this page.
void choose_rules(const PageSource& source, const Tables& usual, PageHeader& header) {
  using page_model::AxisRule;
  const std::span<const PageNode> children = source.nodes.subspan(2 * std::size_t{source.first_split} + 1, 2 * source.splits.size());
  header.leaf_normals =
      std::ranges::any_of(children, [](const PageNode& node) { return node.split == kNeverReplaced && node.normals != kFlatNormals; });
  // [rule] The contexts do not depend on each other, so four trials are enough for all of them; only axes have more than two rules.
  std::array<std::array<std::vector<std::uint32_t>, Context::kContextCount>, page_model::kAxisRules> counts;
  for (std::uint32_t rule = 0; rule < page_model::kAxisRules; ++rule) {
    PageHeader trial = header;
    trial.plain_opacity = trial.plain_along = rule > 0;
    trial.axis_rules.fill(static_cast<AxisRule>(rule));
    Codes codes;
    for (std::size_t i = 0; i < children.size(); ++i) code_look(children[i], source.nodes[source.splits[i / 2].parent], trial, codes);
    counts[rule] = count_symbols(codes);
  }
  const auto cost = [&](std::size_t context, std::uint32_t rule) {
    const std::vector<std::uint32_t>& of = counts[rule][context];
    return of.empty() ? 0.0 : std::min(own_cost_of(of), cost_of(of, usual[context].costs));
  };
  const auto best_of = [&](std::size_t context, std::uint32_t rule_count) {
    std::uint32_t best = 0;
    for (std::uint32_t rule = 1; rule < rule_count; ++rule)
      if (cost(context, rule) < cost(context, best)) best = rule;
    return best;
  };
  header.plain_opacity = best_of(Context::kOpacity, 2) == 1;
  header.plain_along = best_of(Context::kAlong, 2) == 1;
  for (std::size_t i = 0; i < header.axis_rules.size(); ++i)
    header.axis_rules[i] = static_cast<AxisRule>(best_of(Context::kAxis + i, page_model::kAxisRules));
}

PageHeader header_of(const PageSource& source, const Tables& usual) {
  std::vector<QuantisedQuad> children;
  for (const Split& split : source.splits) {
    const ChildQuads quads = child_quads(source.nodes[split.parent].corners, split);
    children.push_back(quads.first);
    children.push_back(quads.second);
  }
  PageHeader header;
  header.split_count = static_cast<std::uint32_t>(source.splits.size());
  const std::vector<page_model::Shape> shapes = common_shapes(children);
  header.shape_count = static_cast<std::uint32_t>(shapes.size());
  std::ranges::copy(shapes, header.shapes.begin());
  header.axis_weights = axis_weights(source.box_extent);
  header.quantised_max = static_cast<std::int32_t>(source.quantised_max);
  choose_rules(source, usual, header);
  return header;
}

}  // namespace

std::vector<Shape> common_shapes(std::span<const QuantisedQuad> quads) {
  constexpr std::size_t kMinShare = 20;  // one quad in so many
  std::vector<Affine> affines;
  for (const QuantisedQuad& quad : quads)
    if (const auto affine = affine_of(quad)) affines.push_back(*affine);
  std::vector<Shape> shapes = {page_model::kParallelogram};
  while (shapes.size() < page_model::kMaxShapes) {
    const auto cluster = take_cluster(affines, quads.size() / kMinShare + 2);
    if (!cluster) break;
    shapes.push_back({fixed_point(cluster->a), fixed_point(cluster->b)});
  }
  return shapes;
}

Result<std::vector<std::uint8_t>> encode_page(const PageSource& source) {
  constexpr int kPlans = 4;  // a fifth gains nothing noticeable
  COPPICE_ASSERT(!source.splits.empty() && source.nodes.size() >= 2 * (source.first_split + source.splits.size()) + 1);
  const Tables usual = default_tables();
  const PageHeader header = header_of(source, usual);
  Tables tables = usual;
  Codes codes;
  std::uint64_t stored = 0;
  Planner planner(source, header);
  for (int plan = 0; plan < kPlans; ++plan) {
    codes = planner.plan(tables);
    stored = choose_tables(codes, usual, 2 * (1 + 2 * header.shape_count), tables);
  }
  std::vector<std::uint8_t> bytes;
  put_header(header, bytes);
  put_tables(tables, stored, bytes);
  put_codes(codes, tables, bytes);
  if (bytes.size() > COPPICE_MAX_PAGE_BYTES) return Error{Status::invalid_argument, "page encoder: page too long"};
  return bytes;
}

}  // namespace coppice::bake
