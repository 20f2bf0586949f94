// Section 9 of FORMAT.md: pages.

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include "naive_reader.h"

namespace coppice::test {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Wide = std::int64_t;

constexpr std::size_t kContexts = 44;
constexpr std::uint32_t kPageSplits = 512;

constexpr std::array<std::uint32_t, 16> kWeights = {0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192};

/// A word for each context, a hexadecimal digit for each symbol.
constexpr const char* kUsualDigits =
    "fa42356789aa9876543211111111 d79c95ecbc4aeccf fede f7996c969a6c 8f88d56765c4 b9fb5bb6ce5c fc9d4885757953243664889a "
    "f12111111125111111111116 b7fed8621123111211 fcfdca612143212121 fafcc8134124411221 f4d611611121112111 f2 1 112468aceffeb621 "
    "1123579bdeffc941 112368acdffec841 1122479bdeffda31 112468acdffec951 33579bceffec7111 24469bdefeec6111 eceffdecbba82111 "
    "3737b73737b7bfb7b73747b7373e 22468acdeffd8111 22468acefffc6111 fcd9544321111111 fdddcdefffed6221 ecefdcbedb9a5211 "
    "fcd8763111111111 1 1 01 001 0001 1 01 001 0001 fdba98767776657b 0000000000000001 fc9aba9c fda87788887768ad "
    "fc97432111111111111111111123569c f741111213121137";

/// floor(a / b), b > 0.
Wide floor_div(Wide a, Wide b) {
  const Wide quotient = a / b;
  return quotient * b > a ? quotient - 1 : quotient;
}

/// `a div b`: the nearest integer, of two the larger.
Wide nearest_div(Wide a, Wide b) {
  return b < 0 ? nearest_div(-a, -b) : floor_div(2 * a + b, 2 * b);
}

/// [v]
Wide in_64ths(Wide value) {
  return floor_div(value + 32, 64);
}

struct Shape {
  Wide a = -4096, b = 4096;
};
struct Range {
  std::uint32_t start = 0, size = 0;
};

std::vector<Range> ranges_of(const std::vector<std::uint32_t>& digits) {
  std::uint32_t sum = 0, above = 0;
  for (const std::uint32_t digit : digits) {
    sum += kWeights[digit];
    above += digit > 0 ? 1 : 0;
  }
  naive_must(sum > 0, "a context without symbols");
  std::vector<Range> ranges(digits.size());
  std::uint32_t used = 0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const std::uint32_t weight = kWeights[digits[i]];
    if (weight > 0) ranges[i].size = 1 + weight * (1020 - above) / sum;
    used += ranges[i].size;
  }
  ranges[static_cast<std::size_t>(std::ranges::max_element(digits) - digits.begin())].size += 1024 - used;
  for (std::size_t i = 1; i < ranges.size(); ++i) ranges[i].start = ranges[i - 1].start + ranges[i - 1].size;
  return ranges;
}

/// The symbols of one context, as Draco's rANS coder stores them: read from the end.
class Block {
 public:
  void set_digits(const std::vector<std::uint32_t>& digits) { ranges_ = ranges_of(digits); }
  [[nodiscard]] bool only_one() const { return ranges_[likeliest()].size == 1024; }

  void start(Bytes bytes) {
    bytes_.assign(bytes.begin(), bytes.end());
    if (bytes_.empty()) return;
    const std::size_t state_bytes = std::size_t{bytes_.back()} / 64 + 1;
    naive_must(state_bytes <= 3 && state_bytes <= bytes_.size(), "a block's state");
    state_ = 0;
    for (std::size_t i = 0; i < state_bytes; ++i) {
      state_ = 256 * state_ + bytes_.back() % (i == 0 ? 64u : 256u);
      bytes_.pop_back();
    }
    state_ += 4096;
    naive_must(state_ < 1048576, "a block's state");
    has_end_ = true;
  }

  std::uint32_t next() {
    while (state_ < 4096) {
      naive_must(!bytes_.empty(), "the symbols end early");
      state_ = 256 * state_ + bytes_.back();
      bytes_.pop_back();
    }
    const std::uint32_t place = state_ % 1024;
    std::uint32_t symbol = 0;
    while (place < ranges_[symbol].start || place >= ranges_[symbol].start + ranges_[symbol].size) ++symbol;
    state_ = ranges_[symbol].size * (state_ / 1024) + place - ranges_[symbol].start;
    return symbol;
  }

  /// After the last split.
  void check_end() {
    if (has_end_) naive_must(next() == likeliest(), "a block's end");
    naive_must(state_ == 4096 && bytes_.empty(), "symbols are left over");
  }

 private:
  [[nodiscard]] std::uint32_t likeliest() const {
    return static_cast<std::uint32_t>(std::ranges::max_element(ranges_, {}, &Range::size) - ranges_.begin());
  }

  std::vector<Range> ranges_;
  std::vector<std::uint8_t> bytes_;
  std::uint32_t state_ = 4096;
  bool has_end_ = false;
};

/// What is before the splits, and the two streams that they are read from.
class PageStream {
 public:
  PageStream(Bytes page, std::uint32_t split_count, std::uint32_t card_count) {
    NaiveBytes bytes(page);
    naive_must(bytes.u16() == split_count, "split_count");
    const std::uint32_t more_shapes = bytes.u8();
    naive_must(more_shapes <= 3, "shape_count");
    rules = bytes.u16();
    naive_must(rules < 2048, "rules");
    for (Wide& weight : axis_weights) weight = bytes.u16();
    for (std::uint32_t i = 0; i < more_shapes; ++i) {
      Shape& shape = shapes.emplace_back();
      shape.a = bytes.i16();
      shape.b = bytes.i16();
    }
    read_tables(bytes, card_count);
    for (Block& block : blocks_) block.start(bytes.take(block.only_one() ? 0 : length(bytes)));
    const std::uint32_t plain_bytes = bytes.u32();
    naive_must(plain_bytes == bytes.left() && plain_bytes % 4 == 0 && plain_bytes <= 14852, "the length of the plain bits");
    while (bytes.left() > 0) plain_.push_back(bytes.u32());
  }

  std::uint32_t rules = 0;
  std::array<Wide, 3> axis_weights{};
  std::vector<Shape> shapes = {{}};

  std::uint32_t symbol(std::size_t context) { return blocks_[context].next(); }

  Wide number(std::uint32_t length) {
    if (length == 0) return 0;
    Wide value = 1;
    for (std::uint32_t i = 0; i + 1 < length; ++i) value = 2 * value + bit();
    return value;
  }

  Wide residual(std::uint32_t length) {
    const Wide value = number(length);
    return value % 2 == 0 ? value / 2 : -(value + 1) / 2;
  }

  /// After the last split.
  void check_end() {
    for (Block& block : blocks_) block.check_end();
    naive_must(plain_.size() == bits_read_ / 32 + 1, "plain bits are left over");
    while (bits_read_ % 32 != 0 || bits_read_ / 32 < plain_.size()) naive_must(bit() == 0, "an unused plain bit");
  }

 private:
  std::uint32_t bit() {
    naive_must(bits_read_ / 32 < plain_.size(), "the plain bits end early");
    const std::uint32_t bit = plain_[bits_read_ / 32] >> (31 - bits_read_ % 32) & 1;
    ++bits_read_;
    return bit;
  }

  /// Draco's varint, of two bytes at most.
  static std::uint32_t length(NaiveBytes& bytes) {
    const std::uint32_t first = bytes.u8();
    if (first < 128) return first;
    const std::uint32_t second = bytes.u8();
    naive_must(second < 128, "a block's length");
    return first - 128 + 128 * second;
  }

  [[nodiscard]] std::size_t alphabet(std::size_t context, std::uint32_t card_count) const {
    constexpr std::array<std::size_t, 8> kFirst = {28, 16, 4, 12, 12, 12, 24, 24};
    if (context < 8) return kFirst[context];
    if (context < 12) return 2 * (1 + 2 * shapes.size());
    if (context == 12) return 2;
    if (context == 13) return card_count;
    if (context >= 30 && context < 38) return 4;
    if (context >= 40) return std::min<std::size_t>(32, 8u << (context - 40));
    if (context >= 29) return 16;
    return context == 22 ? 28 : 17;
  }

  static std::vector<std::uint32_t> stored_digits(NaiveBytes& bytes, std::size_t most) {
    const std::size_t count = std::size_t{bytes.u8()} + 1;
    naive_must(count <= most, "more digits than the alphabet has");
    std::vector<std::uint32_t> digits;
    while (digits.size() < count) {
      const std::uint32_t two = bytes.u8();
      digits.insert(digits.end(), {two % 16, two / 16});
    }
    naive_must(digits.size() == count || digits.back() == 0, "an unused half byte");
    digits.resize(count);
    naive_must(digits.back() != 0, "the last digit is 0");
    return digits;
  }

  static std::vector<std::uint32_t> digits_of(const std::string& word, std::size_t most) {
    std::vector<std::uint32_t> digits;
    for (const char c : word.substr(0, most)) digits.push_back(static_cast<std::uint32_t>(c <= '9' ? c - '0' : c - 'a' + 10));
    return digits;
  }

  void read_tables(NaiveBytes& bytes, std::uint32_t card_count) {
    const std::uint64_t stored = bytes.number(6);
    naive_must(stored >> kContexts == 0, "stored_tables");
    std::istringstream usual(kUsualDigits);
    std::string word;
    for (std::size_t context = 0; usual >> word; ++context) {
      const std::size_t most = alphabet(context, card_count);
      blocks_[context].set_digits((stored >> context & 1) != 0 ? stored_digits(bytes, most) : digits_of(word, most));
    }
  }

  std::array<Block, kContexts> blocks_;
  std::vector<std::uint32_t> plain_;
  std::size_t bits_read_ = 0;
};

enum class Kind : std::uint8_t { free, turned, parallel };
enum class Rule : std::uint8_t { position, first, second, diagonal, fourth };

/// The corners of one child.
class ChildCorners {
 public:
  ChildCorners(PageStream& stream, const NaiveQuad& parent, std::uint32_t kind, Wide largest)
      : stream_(stream), parent_(parent), shape_((kind + 1) / 2 - (kind > 0 ? 1 : 0)), largest_(largest) {
    kind_ = kind == 0 ? Kind::free : kind % 2 == 1 ? Kind::turned : Kind::parallel;
    for (std::size_t a = 0; a < 3; ++a) middle_[a] = floor_div(parent[0][a] + parent[1][a] + parent[2][a] + parent[3][a] + 2, 4);
  }

  NaiveQuad fill(const std::array<std::optional<NaivePoint>, 4>& known) {
    known_ = known;
    while (known_count() < 4) fill_next();
    return {*known_[0], *known_[1], *known_[2], *known_[3]};
  }

 private:
  [[nodiscard]] std::size_t known_count() const {
    return static_cast<std::size_t>(std::ranges::count_if(known_, [](const auto& corner) { return corner.has_value(); }));
  }
  [[nodiscard]] const NaivePoint& q(std::size_t corner) const { return *known_[corner % 4]; }

  void fill_next() {
    const std::size_t count = known_count();
    std::size_t t = 0;
    while (known_[t].has_value() != (count == 1)) ++t;
    if (count == 1) t = (t + 1) % 4;
    t_ = t;
    n_ = count > 1 && known_[(t + 1) % 4] ? (t + 1) % 4 : (t + 3) % 4;
    constexpr std::array<Rule, 4> kRules = {Rule::position, Rule::first, Rule::second, Rule::fourth};
    rule_ = count == 2 && known_[(t + 1) % 4] && known_[(t + 3) % 4] ? Rule::diagonal : kRules[count];
    const NaivePoint corner = decode();
    for (const Wide coordinate : corner) naive_must(coordinate >= 0 && coordinate <= largest_, "a corner is outside the leaf box");
    known_[t] = corner;
  }

  [[nodiscard]] std::size_t context() const {
    if (kind_ == Kind::free) return 14 + static_cast<std::size_t>(rule_);
    if (rule_ == Rule::position) return 19;
    if (rule_ == Rule::diagonal) return 20;
    if (rule_ == Rule::fourth) return 21;
    return (kind_ == Kind::turned ? 23u : 26u) + (rule_ == Rule::second ? 1u : 0u);
  }

  [[nodiscard]] Wide clamped(Wide value) const { return std::clamp<Wide>(value, 0, largest_); }

  /// The guess on one axis, from the table.
  [[nodiscard]] Wide guess(std::size_t a) const {
    const Wide pt = parent_[t_][a], m = middle_[a];
    if (rule_ == Rule::position) return clamped(m + in_64ths((kind_ == Kind::free ? 12 : 38) * (pt - m)));
    if (rule_ == Rule::fourth && kind_ != Kind::free) return clamped(fourth_of_shape(a));
    const Wide qn = q(n_)[a], pn = parent_[n_][a];
    if (kind_ == Kind::parallel && rule_ != Rule::diagonal) return clamped(qn + pt - pn);
    const bool is_free = kind_ == Kind::free;
    Wide sum = 0;
    if (rule_ == Rule::first) {
      sum = is_free ? 5 * (pt - qn) + 34 * (m - qn) : 23 * (pt - qn) - 7 * (pn - qn) + 22 * (m - qn);
    } else if (rule_ == Rule::second) {
      const Wide across = q(t_ + 2)[a] - qn;
      sum = is_free ? -18 * across + 8 * (pt - qn) - 2 * (pn - qn) + 55 * (m - qn)
                    : -28 * across + 6 * (pt - qn) - 7 * (pn - qn) + 58 * (m - qn);
    } else if (rule_ == Rule::diagonal) {
      const Wide before = q(t_ + 3)[a] - qn;
      sum = is_free ? 8 * before + 6 * (pt - qn) + 41 * (m - qn) : 27 * before + 46 * (pt - qn) - 37 * (m - qn);
    } else {
      sum = 17 * (q(t_ + 3)[a] - qn) + 8 * (pt - qn) - 24 * (q(t_ + 2)[a] - qn) + 39 * (m - qn);
    }
    return clamped(qn + in_64ths(sum));
  }

  [[nodiscard]] Wide fourth_of_shape(std::size_t a) const {
    if (shape_ == 0) return q(t_ + 1)[a] + q(t_ + 3)[a] - q(t_ + 2)[a];
    const Shape& shape = stream_.shapes[shape_];
    const std::array<Wide, 4> f = {shape.a + shape.b - 4096, -shape.a, -shape.b, 4096};
    if (f[t_] == 0) return q(t_ + 1)[a];
    Wide sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      if (i != t_) sum += f[i] * q(i)[a];
    return nearest_div(-sum, f[t_]);
  }

  NaivePoint decode() {
    if (rule_ == Rule::fourth && kind_ != Kind::free) return decode_fourth_of_shape();
    if (rule_ == Rule::second && kind_ != Kind::free && shape_ == 0) {
      NaivePoint products{};
      for (std::size_t a = 0; a < 3; ++a) products[a] = std::abs(q(t_ + 2)[a] - q(n_)[a]) * stream_.axis_weights[a];
      const auto m = static_cast<std::size_t>(std::ranges::max_element(products) - products.begin());
      if (products[m] != 0) return decode_square(m);
    }
    return decode_residuals(context());
  }

  NaivePoint decode_residuals(std::size_t context) {
    std::array<std::uint32_t, 3> lengths;
    for (std::uint32_t& length : lengths) length = stream_.symbol(context);
    NaivePoint corner;
    for (std::size_t a = 0; a < 3; ++a) corner[a] = guess(a) + stream_.residual(lengths[a]);
    return corner;
  }

  NaivePoint decode_fourth_of_shape() {
    const Wide symbol = stream_.symbol(22);
    if (symbol == 27) return decode_residuals(21);
    return {guess(0) + symbol / 9 - 1, guess(1) + symbol / 3 % 3 - 1, guess(2) + symbol % 3 - 1};
  }

  /// The axis m follows from the others, for leaves are square.
  NaivePoint decode_square(std::size_t m) {
    const std::array<std::size_t, 3> axes = {(m + 1) % 3, (m + 2) % 3, m};
    const std::size_t last = kind_ == Kind::turned ? 25 : 28;
    std::array<std::uint32_t, 3> lengths;
    for (std::size_t i = 0; i < 3; ++i) lengths[i] = stream_.symbol(i < 2 ? context() : last);
    NaivePoint corner{};
    Wide sum = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t a = axes[i];
      corner[a] = guess(a) + stream_.residual(lengths[i]);
      sum += (q(t_ + 2)[a] - q(n_)[a]) * (corner[a] - q(n_)[a]) * stream_.axis_weights[a];
    }
    const Wide g = nearest_div(-sum, (q(t_ + 2)[m] - q(n_)[m]) * stream_.axis_weights[m]);
    corner[m] = clamped(q(n_)[m] + std::clamp<Wide>(g, -32768, 32768)) + stream_.residual(lengths[2]);
    return corner;
  }

  PageStream& stream_;
  const NaiveQuad& parent_;
  std::size_t shape_;
  Wide largest_;
  Kind kind_ = Kind::free;
  NaivePoint middle_{};
  std::array<std::optional<NaivePoint>, 4> known_;
  std::size_t t_ = 0, n_ = 0;
  Rule rule_ = Rule::position;
};

/// Step 3: which corners of the child the parent's `corners`, ascending, are.
std::array<std::size_t, 4> own_corners(PageStream& stream, const std::vector<std::size_t>& corners) {
  const std::size_t i1 = corners[0];
  if (corners.size() == 1) return {(i1 + stream.symbol(2)) % 4};
  // Two corners have no e, which is as if it were 0.
  const std::size_t symbol = corners.size() == 2 ? 2 * stream.symbol(2 + corners[1] - i1) : stream.symbol(corners.size() == 3 ? 6 : 7);
  const std::size_t t = symbol / 6, d = symbol % 6 / 2 + 1, e = symbol % 2;
  std::array<std::size_t, 4> own{(i1 + t) % 4, (i1 + t + d) % 4};
  std::vector<std::size_t> left;
  for (std::size_t step = 1; step < 4; ++step)
    if (step != d) left.push_back((own[0] + step) % 4);
  own[2] = left[e];
  own[3] = left[1 - e];
  return own;
}

/// floor(sqrt(square))
Wide root_of(Wide square) {
  auto root = static_cast<Wide>(std::sqrt(static_cast<double>(square)));
  while (root * root > square) --root;
  while ((root + 1) * (root + 1) <= square) ++root;
  return root;
}

/// Its vector has the plant's directions.
NaivePoint normal_of(const PageStream& stream, const NaiveQuad& quad) {
  NaivePoint n{};
  for (std::size_t a = 0; a < 3; ++a) {
    const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
    n[a] = (quad[2][b] - quad[0][b]) * (quad[3][c] - quad[1][c]) - (quad[2][c] - quad[0][c]) * (quad[3][b] - quad[1][b]);
    n[a] *= root_of(stream.axis_weights[b] * stream.axis_weights[c]);
  }
  return n;
}

NaivePoint stalk_to_tip(const PageStream& stream, const NaiveQuad& quad) {
  NaivePoint n{};
  for (std::size_t a = 0; a < 3; ++a) n[a] = (quad[1][a] + quad[2][a] - quad[0][a] - quad[3][a]) * root_of(65535 * stream.axis_weights[a]);
  return n;
}

/// u and v, 1 to 2 `half` - 1, of a direction.
std::array<std::uint32_t, 2> axis_along(NaivePoint n, Wide half) {
  Wide sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  if (sum == 0) sum = 1;
  if (n[1] < 0 || (n[1] == 0 && n[0] < 0)) n = {-n[0], -n[1], -n[2]};
  const auto step = [&](Wide share) { return static_cast<std::uint32_t>(half + nearest_div((half - 1) * share, sum)); };
  return {step(n[0] + n[2]), step(n[0] - n[2])};
}

/// Step 6.
void read_normals(PageStream& stream, const NaiveNode& parent, NaiveNode& child) {
  const bool is_source = child.death == kNaiveNone;
  if (is_source && stream.rules / 4 % 2 == 0) return;
  child.side = stream.symbol((is_source ? 34 : 30) + parent.side);
  if (child.side == 3) return;
  child.along = is_source ? stream.symbol(39) : (stream.symbol(38) + (stream.rules / 2 % 2 == 1 ? 0 : parent.along)) % 16;
  const std::uint32_t bits = naive_axis_bits(child.along);
  const std::uint32_t context = is_source ? 43 : 37 + bits, steps = (1u << bits) - 1;
  const std::uint32_t rule = stream.rules >> (3 + 2 * (context - 40)) & 3;
  std::array<std::uint32_t, 2> guess{};
  if (rule == 0)
    for (std::size_t i = 0; i < 2; ++i) guess[i] = static_cast<std::uint32_t>(nearest_div(Wide{parent.axis[i]} * steps, 31));
  if (rule == 1) guess = axis_along(normal_of(stream, child.corners), 1 << (bits - 1));
  if (rule == 2) guess = axis_along(stalk_to_tip(stream, child.corners), 1 << (bits - 1));
  for (std::size_t i = 0; i < 2; ++i) child.axis[i] = naive_axis_step((guess[i] + stream.symbol(context)) & steps, bits);
}

void read_split(PageStream& stream, std::uint32_t s, NaivePlant& plant, std::vector<std::uint32_t>& parents) {
  naive_must(parents[s] != kNaiveNone, "the split replaces no node");
  NaiveSplit split;
  split.parent = parents[s];
  std::array<NaiveNode, 2> children;
  for (std::uint32_t child = 0; child < 2; ++child) {
    const Wide splits = stream.number(stream.symbol(0));
    if (splits == 0) continue;
    naive_must(s + splits < Wide{plant.leaf_count} - 1, "no such split");
    children[child].death = static_cast<std::uint32_t>(s + splits);
    naive_must(parents[children[child].death] == kNaiveNone, "the split replaces another node");
    parents[children[child].death] = 2 * s + 1 + child;
  }
  const NaiveNode parent = plant.nodes[split.parent];
  const std::uint32_t children_of = stream.symbol(1);
  std::array<std::array<std::optional<NaivePoint>, 4>, 2> known;
  std::array<std::size_t, 2> counts{};
  for (std::size_t child = 0; child < 2; ++child) {
    std::vector<std::size_t> corners;
    for (std::size_t i = 0; i < 4; ++i)
      if ((children_of >> i & 1) == child) corners.push_back(i);
    counts[child] = corners.size();
    if (corners.empty()) continue;
    const auto own = own_corners(stream, corners);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      known[child][own[i]] = parent.corners[corners[i]];
      split.parent_slots[corners[i]] = static_cast<std::uint32_t>(4 * child + own[i]);
    }
  }
  const std::size_t fuller = counts[1] > counts[0] ? 1 : 0;
  for (const std::size_t child : {fuller, 1 - fuller}) {
    const std::uint32_t symbol = stream.symbol(8 + counts[child]);
    children[child].card = symbol % 2 == 1 ? stream.symbol(13) : parent.card;
    ChildCorners corners(stream, parent.corners, symbol / 2, plant.largest);
    children[child].corners = corners.fill(known[child]);
  }
  for (NaiveNode& child : children) {
    if (child.death != kNaiveNone) child.opacity = (stream.symbol(29) + (stream.rules % 2 == 1 ? 0 : parent.opacity - 1)) % 16 + 1;
    read_normals(stream, parent, child);
  }
  plant.nodes.insert(plant.nodes.end(), children.begin(), children.end());
  plant.splits.push_back(split);
}

}  // namespace

void read_naive_page(std::span<const std::uint8_t> bytes, NaivePlant& plant, std::vector<std::uint32_t>& parents) {
  const auto first = static_cast<std::uint32_t>(plant.splits.size());
  const std::uint32_t count = std::min(kPageSplits, plant.leaf_count - 1 - first);
  PageStream stream(bytes, count, static_cast<std::uint32_t>(plant.cards.size()));
  for (std::uint32_t i = 0; i < count; ++i) read_split(stream, first + i, plant, parents);
  stream.check_end();
}

}  // namespace coppice::test
