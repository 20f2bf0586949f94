// A page consists of a header, tables of symbol probabilities (if they differ from the default), a block of symbols for each context, and
// plain bits; Draco codes blocks and bits. Splits are decoded one after another straight into nodes. Tables and header are checked first,
// so no symbol can be out of range. A damaged page can then only let a split replace two nodes or none, or leave the quantisation box.

#include "page_codec.h"

#include <algorithm>
#include <bit>
#include <new>
#include <string>
#include <utility>

#include "reader.h"
#include "symbol_reader.h"

namespace coppice {

namespace {

using page_model::Context;
using page_model::PageHeader;
using page_model::Parent;
using page_model::Point;
using page_model::Step;

using Bytes = std::span<const std::uint8_t>;

Error bad_page(const char* what, std::size_t at) {
  return {Status::bad_file, what, Error::kNoOffset, "byte " + std::to_string(at) + " of the page"};
}

Error bad_split(const char* what, std::size_t split) {
  return {Status::bad_file, what, Error::kNoOffset, "split " + std::to_string(split) + " of the page"};
}

/// Reads little-endian numbers from the front of a page.
class HeaderReader {
 public:
  explicit HeaderReader(Bytes bytes) : bytes_(bytes) {}

  [[nodiscard]] bool has(std::size_t count) const { return bytes_.size() - at_ >= count; }
  [[nodiscard]] std::size_t at() const { return at_; }
  /// The caller has checked the length.
  std::uint32_t number(std::size_t byte_count) { return static_cast<std::uint32_t>(long_number(byte_count)); }
  /// The same, of up to eight bytes.
  std::uint64_t long_number(std::size_t byte_count) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < byte_count; ++i) value |= std::uint64_t{bytes_[at_++]} << (8 * i);
    return value;
  }
  Bytes take(std::size_t byte_count) {
    at_ += byte_count;
    return bytes_.subspan(at_ - byte_count, byte_count);
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  Bytes bytes_;
  std::size_t at_ = 0;
};

/// Number of symbols of a context that this page may use.
std::size_t alphabet(std::size_t context, const PageHeader& header, std::uint32_t card_count) {
  if (context == Context::kCard) return card_count;
  if (context >= Context::kKind && context < Context::kKind + 4) return 2 * (1 + 2 * std::size_t{header.shape_count});
  return page_model::kAlphabet[context];
}

Result<void> read_header(HeaderReader& reader, std::uint32_t split_count, PageHeader& header) {
  constexpr std::size_t kFixedBytes = 11, kShapeBytes = 4;
  if (!reader.has(kFixedBytes)) return bad_page("page header", 0);
  header.split_count = reader.number(2);
  if (header.split_count != split_count) return bad_page("page split_count", 0);
  header.shape_count = 1 + reader.number(1);
  if (header.shape_count > page_model::kMaxShapes) return bad_page("page shape_count", 2);
  const std::uint32_t rules = reader.number(2);
  if (rules >= 1u << (3 + 2 * header.axis_rules.size())) return bad_page("page rules", 3);
  header.plain_opacity = (rules & 1) != 0;
  header.plain_along = (rules & 2) != 0;
  header.leaf_normals = (rules & 4) != 0;
  for (std::size_t i = 0; i < header.axis_rules.size(); ++i)
    header.axis_rules[i] = static_cast<page_model::AxisRule>(rules >> (3 + 2 * i) & 3);
  for (std::uint16_t& weight : header.axis_weights) weight = static_cast<std::uint16_t>(reader.number(2));
  if (!reader.has(kShapeBytes * (header.shape_count - 1))) return bad_page("page shapes", reader.at());
  for (std::size_t i = 1; i < header.shape_count; ++i) {
    header.shapes[i].a = static_cast<std::int16_t>(reader.number(2));
    header.shapes[i].b = static_cast<std::int16_t>(reader.number(2));
  }
  return {};
}

std::uint8_t digit_of(char hexadecimal) {
  return static_cast<std::uint8_t>(hexadecimal <= '9' ? hexadecimal - '0' : hexadecimal - 'a' + 10);
}

/// Writes the default weights of a context. If the page may use fewer kinds or cards, it gets the first `maximum`.
std::size_t default_digits(std::size_t context, std::size_t maximum, std::array<std::uint8_t, 256>& digits) {
  const char* text = page_model::kDefaultWeights[context];
  std::size_t count = 0;
  for (; count < maximum && text[count] != 0; ++count) digits[count] = digit_of(text[count]);
  return count;
}

/// Reads a context's weights: a count, then that many digits, two to a byte.
Result<std::size_t> read_digits(HeaderReader& reader, std::size_t maximum, std::array<std::uint8_t, 256>& digits) {
  const std::size_t at = reader.at();
  if (!reader.has(1)) return bad_page("page tables", at);
  const std::size_t count = reader.number(1) + 1;
  if (count > maximum) return bad_page("page tables", at);
  if (!reader.has((count + 1) / 2)) return bad_page("page tables", at);
  for (std::size_t i = 0; i < count; i += 2) {
    const std::uint32_t pair = reader.number(1);
    digits[i] = pair & 15;
    if (i + 1 < count) digits[i + 1] = static_cast<std::uint8_t>(pair >> 4);
    if (i + 1 == count && pair >> 4 != 0) return bad_page("page tables", at);
  }
  if (digits[count - 1] == 0) return bad_page("page tables", at);
  return count;
}

Result<void> read_tables(HeaderReader& reader, const PageHeader& header, std::uint32_t card_count, DecoderPool::Set& decoders) {
  if (!reader.has(page_model::kStoredBytes)) return bad_page("page tables", reader.at());
  const std::size_t at = reader.at();
  const std::uint64_t stored = reader.long_number(page_model::kStoredBytes);
  if (stored >> Context::kContextCount != 0) return bad_page("page tables", at);
  for (std::size_t context = 0; context < Context::kContextCount; ++context) {
    std::array<std::uint8_t, 256> digits;
    const std::size_t maximum = alphabet(context, header, card_count);
    std::size_t& usual = decoders.usual[context];
    if ((stored >> context & 1) != 0) {
      COPPICE_TRY(count, read_digits(reader, maximum, digits));
      decoders.symbols[context].set_table(std::span(digits).first(count));
      usual = 0;
    } else if (const std::size_t count = default_digits(context, maximum, digits); usual != count) {
      decoders.symbols[context].set_table(std::span(digits).first(count));
      usual = count;
    }
  }
  return {};
}

/// Reads a length with seven bits a byte, the lowest first.
Result<std::size_t> read_length(HeaderReader& reader) {
  constexpr std::uint32_t kLongestBytes = 2;  // 512 splits need no more bytes in any context
  const std::size_t at = reader.at();
  std::size_t length = 0;
  for (std::uint32_t i = 0; i < kLongestBytes; ++i) {
    if (!reader.has(1)) break;
    const std::uint32_t byte = reader.number(1);
    length |= std::size_t{byte & 127} << (7 * i);
    if (byte < 128) return length;
  }
  return bad_page("page symbols", at);
}

Result<void> start_symbols(HeaderReader& reader, DecoderPool::Set& decoders) {
  for (SymbolReader& symbols : decoders.symbols) {
    std::size_t length = 0;
    const std::size_t at = reader.at();
    if (!symbols.only_one()) {
      COPPICE_TRY(stored, read_length(reader));
      length = stored;
    }
    if (!reader.has(length) || !symbols.start(reader.take(length))) return bad_page("page symbols", at);
  }
  return {};
}

Result<PageHeader> read_sections(Bytes bytes, const PageInfo& info, DecoderPool::Set& decoders) {
  PageHeader header;
  HeaderReader reader(bytes);
  COPPICE_CHECK(read_header(reader, page_split_count(info.leaf_count, info.page), header));
  header.quantised_max = static_cast<std::int32_t>(info.quantised_max);
  COPPICE_CHECK(read_tables(reader, header, info.card_count, decoders));
  COPPICE_CHECK(start_symbols(reader, decoders));
  const std::size_t at = reader.at();
  if (reader.left() > BitReader::kMaxBytes || !decoders.bits.start(reader.take(reader.left()))) return bad_page("page plain bits", at);
  return header;
}

/// A child while it is being filled in.
struct Child {
  std::array<Point, 4> corners{};
  unsigned known = 0;  ///< bit i: corner i
  std::uint32_t card = 0;
};

constexpr std::uint32_t kNoParent = 0xffffffffu;

/// Finds the nodes of earlier pages that the page's splits replace. False if a split replaces two nodes: the pages are not from one file.
bool find_parents(const PageInfo& info, const NodePages& nodes, PageScratch& scratch) {
  const std::uint32_t first_split = info.page * COPPICE_PAGE_SPLITS, count = page_split_count(info.leaf_count, info.page);
  scratch.parents.fill(kNoParent);
  if (info.page == 0) scratch.parents[0] = 0;
  for (std::uint32_t page = 0; page < info.page; ++page) {
    const std::span<const PageNode> earlier(nodes.pages[page], std::size_t{2} * COPPICE_PAGE_SPLITS);
    const auto first = std::ranges::partition_point(
        earlier, [&](std::uint16_t place) { return place != kNoPlace && earlier[place].split < first_split; }, &PageNode::by_death);
    for (auto it = first; it != earlier.end() && it->by_death != kNoPlace; ++it) {
      const std::uint32_t place = earlier[it->by_death].split - first_split;
      if (place >= count) break;
      if (scratch.parents[place] != kNoParent) return false;
      scratch.parents[place] = 2 * COPPICE_PAGE_SPLITS * page + it->by_death + 1;
    }
  }
  return true;
}

/// Fills in PageNode::by_death, so that later pages find their parents without reading every node.
void index_by_death(std::span<PageNode> nodes, PageScratch& scratch) {
  constexpr unsigned kPlaceBits = 16;
  std::size_t count = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (nodes[i].split != kNeverReplaced) scratch.deaths[count++] = std::uint64_t{nodes[i].split} << kPlaceBits | i;
  std::sort(scratch.deaths.begin(), scratch.deaths.begin() + static_cast<std::ptrdiff_t>(count));
  for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k].by_death = k < count ? static_cast<std::uint16_t>(scratch.deaths[k]) : kNoPlace;
}

class PageDecoder {
 public:
  PageDecoder(const PageHeader& header, const PageInfo& info, const PageOutput& out, PageScratch& scratch, DecoderPool::Set& decoders)
      : header_(header),
        out_(out),
        scratch_(scratch),
        decoders_(decoders),
        first_split_(info.page * COPPICE_PAGE_SPLITS),
        end_split_(info.leaf_count - 1) {}

  Result<void> run(std::uint32_t split_count) {
    PageNode* nodes = out_.nodes.pages.back();
    for (std::uint32_t i = 0; i < split_count; ++i)
      if (const char* fault = read_split(i, nodes + 2 * std::size_t{i}); fault != nullptr) return bad_split(fault, i);
    for (std::size_t context = 0; context < Context::kContextCount; ++context)
      if (!decoders_.symbols[context].finished())
        return Error{Status::bad_file, "page symbols", Error::kNoOffset, "context " + std::to_string(context) + " ends early or late"};
    if (!decoders_.bits.finished()) return Error{Status::bad_file, "page plain bits", Error::kNoOffset, "end early or late"};
    return {};
  }

 private:
  std::uint32_t symbol(std::size_t context) { return decoders_.symbols[context].next(); }

  /// Reads a number of `length` bits, the highest of which is 1.
  std::uint32_t number(std::uint32_t length) {
    if (length < 2) return length;
    return 1u << (length - 1) | decoders_.bits.next(length - 1);
  }

  /// Returns null, or what is wrong with the split.
  const char* read_split(std::uint32_t i, PageNode* children) {
    const std::uint32_t split = first_split_ + i;
    const std::uint32_t parent_node = scratch_.parents[i];
    if (parent_node == kNoParent) return "page parent";
    for (std::uint32_t c = 0; c < 2; ++c)
      if (!read_death(split, 2 * split + 1 + c, children[c])) return "page death";
    const PageNode& parent = out_.nodes[parent_node];
    const Parent around = page_model::parent_of(parent.corners);
    std::array<Child, 2> child;
    std::array<std::uint8_t, 4> slots{};
    const std::uint32_t pattern = symbol(Context::kChildren);
    read_corners(pattern, 0, around, child[0], slots);
    read_corners(pattern, 1, around, child[1], slots);
    // The child with more known corners comes first.
    const std::size_t fuller = page_model::kBitCount[pattern] > 2 ? 1 : 0;
    if (!read_child(parent.card, around, child[fuller]) || !read_child(parent.card, around, child[1 - fuller])) return "page vertex";
    for (std::size_t c = 0; c < 2; ++c) {
      store(child[c], children[c]);
      children[c].opacity = children[c].split == kNeverReplaced ? kOpaque : read_opacity(parent.opacity);
      children[c].normals = read_normals(children[c], child[c].corners, parent.normals);
      children[c].reserved = 0;
    }
    if (!out_.splits.empty()) store_split(parent_node, slots, child, out_.splits[i]);
    return nullptr;
  }

  /// False if the split that replaces the node does not exist or replaces another node, as far as it is known.
  bool read_death(std::uint32_t birth, std::uint32_t id, PageNode& node) {
    const std::uint32_t lifetime = number(symbol(Context::kDeath));
    node.split = lifetime == 0 ? kNeverReplaced : birth + lifetime;
    if (lifetime == 0) return true;
    if (node.split >= end_split_) return false;
    const std::uint32_t place = node.split - first_split_;
    if (place >= COPPICE_PAGE_SPLITS) return true;  // a later page checks it
    return std::exchange(scratch_.parents[place], id) == kNoParent;
  }

  std::uint8_t read_opacity(std::uint8_t parent_opacity) {
    const std::uint32_t from = header_.plain_opacity ? 0 : parent_opacity - 1u;
    return static_cast<std::uint8_t>(1 + (from + symbol(Context::kOpacity)) % kOpaque);
  }

  /// `node` is filled in, but for its normals.
  std::uint16_t read_normals(const PageNode& node, const std::array<Point, 4>& corners, std::uint16_t parent_normals) {
    const bool is_source = node.split == kNeverReplaced;
    if (is_source && !header_.leaf_normals) return kFlatNormals;
    const auto side = static_cast<NormalSide>(symbol(Context::kSide + page_model::side_class(is_source, side_of(parent_normals))));
    if (side == NormalSide::own_quad) return kFlatNormals;
    const std::uint32_t from = is_source || header_.plain_along ? 0 : along_step_of(parent_normals);
    const std::uint32_t along = (from + symbol(is_source ? Context::kLeafAlong : Context::kAlong)) & kAlongSteps;
    const std::size_t axis = page_model::axis_class(is_source, along);
    const std::uint32_t bits = axis_bits(along), mask = (1u << bits) - 1;
    auto [u, v] = page_model::guess_axis(header_, header_.axis_rules[axis], bits, corners, parent_normals);
    u = (u + symbol(Context::kAxis + axis)) & mask;
    v = (v + symbol(Context::kAxis + axis)) & mask;
    return pack_normals(axis_step_from(u, bits), axis_step_from(v, bits), along, side);
  }

  /// Copies the corners of child `c` that are the parent's.
  void read_corners(std::uint32_t pattern, unsigned c, const Parent& parent, Child& child, std::array<std::uint8_t, 4>& slots) {
    const unsigned mask = (c == 0 ? ~pattern : pattern) & 15;
    if (mask == 0) return;
    const unsigned count = page_model::kBitCount[mask];
    const unsigned first = static_cast<unsigned>(std::countr_zero(mask));
    unsigned code = 0, turn = 0;
    if (count == 1) {
      turn = symbol(Context::kCorners1);
    } else if (count == 2) {
      const unsigned gap = static_cast<unsigned>(std::bit_width(mask)) - 1 - first;
      code = symbol(Context::kCorners2 + gap - 1);
      turn = code / 3;
      code = 2 * (code % 3);
    } else {
      code = symbol(count == 3 ? Context::kCorners3 : Context::kCorners4);
      turn = code / 6;
      code %= 6;
    }
    unsigned left = mask;
    for (unsigned k = 0; left != 0; ++k, left &= left - 1) {
      const auto i = static_cast<unsigned>(std::countr_zero(left));
      const unsigned corner = (first + turn + page_model::kCornerOrders[code][k]) & 3;
      child.corners[corner] = parent.corners[i];
      child.known |= 1u << corner;
      slots[i] = static_cast<std::uint8_t>(4 * c + corner);
    }
  }

  /// Reads card and new corners; false if a corner is outside the box.
  bool read_child(std::uint32_t parent_card, const Parent& parent, Child& child) {
    const std::uint32_t code = symbol(Context::kKind + std::size_t{page_model::kBitCount[child.known]});
    const std::uint32_t kind = code >> 1;
    child.card = (code & 1) != 0 ? symbol(Context::kCard) : parent_card;
    const page_model::Steps& steps = page_model::kSteps[child.known];
    bool inside = true;
    for (std::uint32_t s = 0; s < steps.count; ++s) {
      const Step& step = steps.step[s];
      const Point guess = page_model::predict(header_, kind, step, child.corners, parent);
      read_corner(kind, step, guess, child.corners);
      for (std::int32_t coordinate : child.corners[step.corner])
        inside = inside && static_cast<std::uint32_t>(coordinate) <= static_cast<std::uint32_t>(header_.quantised_max);
    }
    return inside;
  }

  void read_corner(std::uint32_t kind, const Step& step, const Point& guess, std::array<Point, 4>& corners) {
    Point& corner = corners[step.corner];
    if (kind == page_model::kFree) return read_residual(Context::kFreeSteps + static_cast<std::size_t>(step.rule), guess, corner);
    const std::size_t side = page_model::is_parallel(kind) ? Context::kParallel : Context::kTurned;
    switch (step.rule) {
      case page_model::Rule::position:
        return read_residual(Context::kShapedPosition, guess, corner);
      case page_model::Rule::first:
        return read_residual(side + page_model::kFirstSide, guess, corner);
      case page_model::Rule::diagonal:
        return read_residual(Context::kShapedDiagonal, guess, corner);
      case page_model::Rule::fourth: {
        const std::uint32_t near = symbol(Context::kNearFourth);
        if (near == page_model::kFar) return read_residual(Context::kShapedFourth, guess, corner);
        corner = {guess[0] + static_cast<std::int32_t>(near / 9) - 1, guess[1] + static_cast<std::int32_t>(near / 3 % 3) - 1,
                  guess[2] + static_cast<std::int32_t>(near % 3) - 1};
        return;
      }
      case page_model::Rule::second:
        break;
    }
    const Point& base = corners[step.neighbour];
    const Point along = page_model::difference(corners[(step.corner + 2) & 3], base);
    const std::size_t square = page_model::shape_of(kind) == page_model::kParallelogramIndex ? page_model::square_axis(header_, along) : 3;
    if (square == 3) return read_residual(side + page_model::kSecondSide, guess, corner);
    read_square(side, {base, along, square}, guess, corner);
  }

  void read_residual(std::size_t context, const Point& guess, Point& corner) {
    const std::uint32_t x = symbol(context), y = symbol(context), z = symbol(context);
    read_values({x, y, z}, {0, 1, 2}, guess, corner);
  }

  /// A side that is known to be at right angles to another.
  struct SquareSide {
    const Point& base;
    const Point& along;
    std::size_t axis;
  };

  void read_square(std::size_t side, const SquareSide& known, const Point& guess, Point& corner) {
    const std::size_t first = (known.axis + 1) % 3, second = (known.axis + 2) % 3;
    const std::uint32_t a = symbol(side + page_model::kSecondSide), b = symbol(side + page_model::kSecondSide);
    const std::uint32_t c = symbol(side + page_model::kSquareAxis);
    Point residual = guess;
    residual[known.axis] = 0;
    read_values({a, b, c}, {first, second, known.axis}, residual, corner);
    const std::int32_t value = page_model::square_coordinate(header_, known.along, page_model::difference(corner, known.base), known.axis);
    corner[known.axis] += page_model::clamp_coordinate(header_, known.base[known.axis] + value);
  }

  /// Adds the three residuals, whose bit lengths are known, to the guess.
  void read_values(const std::array<std::uint32_t, 3>& lengths, const std::array<std::size_t, 3>& axes, const Point& guess, Point& out) {
    for (std::size_t i = 0; i < 3; ++i) out[axes[i]] = guess[axes[i]] + unzigzag(number(lengths[i]));
  }

  static void store(const Child& child, PageNode& node) {
    for (std::size_t corner = 0; corner < 4; ++corner)
      for (std::size_t axis = 0; axis < 3; ++axis) node.corners[corner][axis] = static_cast<std::uint16_t>(child.corners[corner][axis]);
    node.card = static_cast<std::uint8_t>(child.card);
  }

  static void store_split(std::uint32_t parent, const std::array<std::uint8_t, 4>& slots, const std::array<Child, 2>& child, Split& split) {
    split.parent = parent;
    split.parent_slots = slots;
    std::size_t next = 0;
    for (std::size_t slot = 0; slot < 8; ++slot) {
      const Child& of = child[slot / 4];
      if ((of.known >> (slot % 4) & 1) != 0) continue;
      for (std::size_t axis = 0; axis < 3; ++axis) split.new_vertices[next][axis] = static_cast<std::uint16_t>(of.corners[slot % 4][axis]);
      ++next;
    }
    for (std::size_t c = 0; c < 2; ++c) split.cards[c] = static_cast<std::uint8_t>(child[c].card);
  }

  const PageHeader& header_;
  const PageOutput& out_;
  PageScratch& scratch_;
  DecoderPool::Set& decoders_;
  std::uint32_t first_split_;
  std::uint32_t end_split_;  ///< the plant's
};

}  // namespace

PageNode root_node(const coppice_file_plant& plant) {
  PageNode root{.card = plant.root_card,
                .opacity = plant.root_opacity,
                .split = plant.leaf_count > 1 ? 0 : kNeverReplaced,
                .normals = plant.root_normals};
  for (std::size_t corner = 0; corner < 4; ++corner) std::copy_n(plant.root_quad[corner], 3, root.corners[corner].begin());
  return root;
}

Result<void> decode_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out, PageScratch& scratch,
                         DecoderPool& decoders) {
  const std::uint32_t split_count = page_split_count(info.leaf_count, info.page);
  if (split_count == 0 || out.nodes.root == nullptr || out.nodes.pages.size() != info.page + std::size_t{1} ||
      (!out.splits.empty() && out.splits.size() != split_count))
    return Error{Status::invalid_argument, "decode_page: a span of the wrong length"};
  try {
    const DecoderPool::Lease lease(decoders);
    COPPICE_TRY(header, read_sections(bytes, info, *lease));
    if (!find_parents(info, out.nodes, scratch)) return bad_page("page parent", 0);
    COPPICE_CHECK(PageDecoder(header, info, out, scratch, *lease).run(split_count));
  } catch (const std::bad_alloc&) {
    return Error{Status::out_of_memory, "page decoders"};
  } catch (...) {
    return bad_page("page", 0);
  }
  index_by_death({out.nodes.pages.back(), std::size_t{2} * split_count}, scratch);
  return {};
}

}  // namespace coppice
