#include "page_codec.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "atomic_file.h"
#include "decoded_pages.h"
#include "gltf_builder.h"
#include "page_encode.h"
#include "places.h"
#include "quantised_tree.h"
#include "random_tree.h"
#include "results.h"

namespace coppice::page_codec_test {

using bake::QuantisedTree;
using page_model::AxisRule;
using page_model::Point;
using page_model::Rule;

QuantisedTree quantised(std::uint32_t leaf_count, std::uint32_t seed = 1, std::uint32_t card_count = 2,
                        test::Looks looks = test::Looks::plain) {
  bake::Tree tree = test::random_tree(test::random_foliage(leaf_count, seed, card_count), seed);
  test::set_looks(tree, looks, seed);
  return *bake::quantise_tree(tree);
}

std::uint32_t splits_in_page(const QuantisedTree& tree, std::uint32_t page) {
  return std::min(COPPICE_PAGE_SPLITS, static_cast<std::uint32_t>(tree.splits.size()) - page * COPPICE_PAGE_SPLITS);
}

std::vector<std::uint8_t> encoded(const QuantisedTree& tree, std::uint32_t page = 0) {
  const std::uint32_t first = page * COPPICE_PAGE_SPLITS;
  return *bake::encode_page(
      {std::span(tree.splits).subspan(first, splits_in_page(tree, page)), first, tree.nodes, tree.box.max - tree.box.min});
}

/// The tree's first page decoded from `bytes`.
Result<std::vector<Split>> decoded(const QuantisedTree& tree, std::span<const std::uint8_t> bytes, std::uint32_t card_count = 2) {
  return bake::DecodedPages(tree.nodes[0], static_cast<std::uint32_t>(tree.splits.size() + 1), card_count).add(bytes);
}

// Everything a page says comes back, and its nodes know what replaces them, in later pages too.
void expect_round_trip(const QuantisedTree& tree, std::uint32_t card_count) {
  bake::DecodedPages pages(tree.nodes[0], static_cast<std::uint32_t>(tree.splits.size() + 1), card_count);
  for (std::uint32_t page = 0; page * COPPICE_PAGE_SPLITS < tree.splits.size(); ++page) {
    const auto splits = test::must(pages.add(encoded(tree, page)));
    for (std::size_t i = 0; i < splits.size(); ++i) {
      const Split &split = splits[i], &expected = tree.splits[page * COPPICE_PAGE_SPLITS + i];
      EXPECT_EQ(split.parent, expected.parent);
      EXPECT_EQ(split.parent_slots, expected.parent_slots);
      EXPECT_EQ(split.new_vertices, expected.new_vertices);
      EXPECT_EQ(split.cards, expected.cards);
    }
  }
  const std::vector<PageNode> nodes = pages.nodes();
  ASSERT_EQ(nodes.size(), tree.nodes.size());
  for (std::size_t node = 1; node < nodes.size(); ++node) {
    EXPECT_EQ(nodes[node].corners, tree.nodes[node].corners);
    EXPECT_EQ(nodes[node].card, tree.nodes[node].card);
    EXPECT_EQ(nodes[node].opacity, tree.nodes[node].opacity);
    EXPECT_EQ(nodes[node].normals, tree.nodes[node].normals) << node;
    EXPECT_EQ(nodes[node].split, tree.nodes[node].split);
  }
}

TEST(PageCodec, GivesBackEverySplitAndNode) {
  for (const test::Looks looks : {test::Looks::plain, test::Looks::smooth, test::Looks::sided, test::Looks::noise})
    for (std::uint32_t leaf_count : {2u, 3u, 10u, 513u, 514u, 1500u}) expect_round_trip(quantised(leaf_count, leaf_count, 2, looks), 2);
  for (std::uint32_t card_count : {1u, 17u, 256u}) expect_round_trip(quantised(700, 3, card_count), card_count);
}

TEST(PageCodec, GivesBackEverySideAndAlong) {
  QuantisedTree tree = quantised(700);
  for (std::uint32_t i = 0; i < tree.nodes.size(); ++i)
    if (i % 7 != 0)
      tree.nodes[i].normals = test::coarse_enough(pack_normals(i * 11 % 32, i * 5 % 32, i / 3 % 16, static_cast<NormalSide>(i % 3)));
  expect_round_trip(tree, 2);
}

/// A page's statement how opacities and normals are guessed.
std::uint32_t rules_of(const QuantisedTree& tree) {
  const std::vector<std::uint8_t> page = encoded(tree);
  return page[3] | std::uint32_t{page[4]} << 8;
}

TEST(PageCodec, LooksThatAreNotThereTakeNoBytes) {
  QuantisedTree tree = quantised(500);
  const std::size_t bytes = encoded(tree).size();
  for (PageNode& node : tree.nodes)
    if (node.split != kNeverReplaced) node.opacity = 5;  // the root's, and all others' are as it
  EXPECT_EQ(encoded(tree).size(), bytes);
  expect_round_trip(tree, 2);
}

TEST(PageCodec, NormalsWithoutSidesTakeNoBytesForThem) {
  QuantisedTree tree = quantised(500);
  const std::uint16_t up = pack_normals(16, 16, 13, NormalSide::either);
  tree.nodes[0].normals = up;
  for (PageNode& node : tree.nodes)
    if (node.split != kNeverReplaced) node.normals = up;
  const std::size_t without = encoded(tree).size();
  EXPECT_EQ(rules_of(tree), 0u);
  for (PageNode& node : tree.nodes)
    if (node.split != kNeverReplaced) node.normals = pack_normals(16, 16, 13, NormalSide::along);
  EXPECT_EQ(encoded(tree).size(), without) << "a side that is the parent's takes none either";
  std::uint32_t next = 0;
  for (PageNode& node : tree.nodes)
    if (node.split != kNeverReplaced) node.normals = pack_normals(16, 16, 13, next++ % 3 == 0 ? NormalSide::along : NormalSide::against);
  EXPECT_GT(encoded(tree).size(), without + 499 / 8);
  expect_round_trip(tree, 2);
}

TEST(PageCodec, SourceLeavesHaveNormalsWhereThePageSaysSo) {
  QuantisedTree tree = quantised(500, 1, 2, test::Looks::smooth);
  EXPECT_EQ(rules_of(tree) & 4, 0u);
  const std::size_t without = encoded(tree).size();
  for (PageNode& node : tree.nodes)
    if (node.split == kNeverReplaced) {
      node.normals = pack_normals(3, 20, 15, NormalSide::along);
      break;
    }
  EXPECT_EQ(rules_of(tree) & 4, 4u);
  EXPECT_GT(encoded(tree).size(), without);
  expect_round_trip(tree, 2);
}

TEST(PageCodec, LooksAreGuessedFromWhatTakesTheFewestBits) {
  EXPECT_EQ(rules_of(quantised(500)), 0u);
  EXPECT_EQ(rules_of(quantised(500, 1, 2, test::Looks::smooth)), 0u);
  QuantisedTree tree = quantised(500);
  for (std::size_t node = 0; node < tree.nodes.size(); ++node)
    if (tree.nodes[node].split != kNeverReplaced) tree.nodes[node].opacity = static_cast<std::uint8_t>(10 + node * 7 % 5);
  EXPECT_EQ(rules_of(tree), 1u) << "opacities are what they are, whatever their parents'";
  expect_round_trip(tree, 2);

  tree = quantised(500);
  page_model::PageHeader header;  // the axis_weights of the page
  const std::vector<std::uint8_t> page = encoded(tree);
  for (std::size_t axis = 0; axis < 3; ++axis)
    header.axis_weights[axis] = static_cast<std::uint16_t>(page[5 + 2 * axis] | page[6 + 2 * axis] << 8);
  const auto normals_by = [&](const PageNode& node, AxisRule rule, std::uint32_t along) {
    std::array<Point, 4> corners;
    std::ranges::transform(node.corners, corners.begin(), page_model::point_of);
    const std::uint32_t bits = axis_bits(along);
    const auto [u, v] = page_model::guess_axis(header, rule, bits, corners, 0);
    return pack_normals(axis_step_from(u, bits), axis_step_from(v, bits), along, NormalSide::either);
  };
  std::uint32_t next = 0;
  for (PageNode& node : tree.nodes) {
    ++next;
    if (node.split == kNeverReplaced)
      node.normals = normals_by(node, AxisRule::spine, 0);
    else if (next % 3 == 0)
      node.normals = normals_by(node, AxisRule::quad, 13);
    else if (next % 3 == 1)
      node.normals = normals_by(node, AxisRule::spine, 11);
    else  // has nothing to do with its quad or parent
      node.normals = next * 7 % 11 < 5 ? pack_normals(4, 22, 4, NormalSide::either) : pack_normals(22, 9, 4, NormalSide::either);
  }
  const auto rule_of = [&](std::size_t axis_class) { return static_cast<AxisRule>(rules_of(tree) >> (3 + 2 * axis_class) & 3); };
  EXPECT_EQ(rules_of(tree) & 7, 2u | 4u) << "alongs as they are, and normals of source leaves";
  EXPECT_EQ(rule_of(0), AxisRule::plain);
  EXPECT_EQ(rule_of(1), AxisRule::spine);
  EXPECT_EQ(rule_of(2), AxisRule::quad);
  EXPECT_EQ(rule_of(3), AxisRule::spine) << "source leaves";
  expect_round_trip(tree, 2);
}

/// Splits that no baker makes: corners anywhere in the box, slots in any order.
QuantisedTree random_splits(std::uint32_t split_count, std::uint32_t seed) {
  QuantisedTree tree{{glm::vec3(0.0f), glm::vec3(1.0f, 2.0f, 0.5f)}, {PageNode{}}, {}};
  std::uint32_t state = seed;
  const auto below = [&](std::uint32_t limit) {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) % limit;
  };
  for (std::uint32_t s = 0; s < split_count; ++s) {
    Split split;
    do split.parent = below(2 * s + 1);
    while (tree.nodes[split.parent].split != kNeverReplaced);
    std::array<std::uint8_t, 8> slots = {0, 1, 2, 3, 4, 5, 6, 7};
    for (std::uint32_t i = 0; i < 4; ++i) {
      std::swap(slots[i], slots[i + below(8 - i)]);
      split.parent_slots[i] = slots[i];
    }
    for (auto& vertex : split.new_vertices)
      for (std::uint16_t& coordinate : vertex)
        coordinate = static_cast<std::uint16_t>(below(3) == 0 ? below(2) * COPPICE_QUANTISED_MAX : below(16384));
    split.cards = {static_cast<std::uint8_t>(below(9)), static_cast<std::uint8_t>(below(9))};
    const ChildQuads quads = child_quads(tree.nodes[split.parent].corners, split);
    tree.nodes[split.parent].split = s;
    tree.nodes[split.parent].opacity = static_cast<std::uint8_t>(1 + below(16));
    tree.nodes.push_back({quads.first, split.cards[0]});
    tree.nodes.push_back({quads.second, split.cards[1]});
    for (std::uint32_t child = 2 * s + 1; child <= 2 * s + 2; ++child)
      if (const auto bits = test::coarse_enough(static_cast<std::uint16_t>(below(1u << 16))); are_normals(bits))
        tree.nodes[child].normals = bits;
    tree.splits.push_back(split);
  }
  return tree;
}

TEST(PageCodec, GivesBackSplitsThatMakeNoSense) {
  for (std::uint32_t seed = 1; seed < 6; ++seed) expect_round_trip(random_splits(600, seed), 9);
}

TEST(PageCodec, LeavesOfOneShapeTakeFewerBytes) {
  QuantisedTree kites = random_splits(400, 1), scattered = kites;
  for (Split& split : kites.splits) split.parent_slots = {0, 1, 2, 3};
  scattered.splits = kites.splits;
  const auto rebuild = [](QuantisedTree& tree, bool kite) {
    std::uint32_t salt = 0;
    for (std::uint32_t s = 0; s < tree.splits.size(); ++s) {
      auto& v = tree.splits[s].new_vertices;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t corner = 1; corner < 3; ++corner)
          v[corner][axis] = static_cast<std::uint16_t>((v[corner][axis] + 7 * v[0][axis]) / 8);
        // corner 3 = corner 0 + (corner 2 - corner 1) / 2 for a kite, anywhere near for the others
        const int fourth = v[0][axis] + (v[2][axis] - v[1][axis]) / 2 + (kite ? 0 : static_cast<int>(salt++ * 7919 % 2000) - 1000);
        v[3][axis] = static_cast<std::uint16_t>(std::clamp(fourth, 0, 16383));
      }
      const ChildQuads quads = child_quads(tree.nodes[tree.splits[s].parent].corners, tree.splits[s]);
      tree.nodes[2 * s + 1].corners = quads.first;
      tree.nodes[2 * s + 2].corners = quads.second;
    }
  };
  rebuild(kites, true);
  rebuild(scattered, false);
  expect_round_trip(kites, 9);
  EXPECT_LT(encoded(kites).size() + std::size_t{400} * 2, encoded(scattered).size());
}

void expect_valid(const std::vector<Split>& splits) {
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const Split& split = splits[i];
    ASSERT_LE(split.parent, 2 * i);
    ASSERT_EQ(std::set<std::uint8_t>(split.parent_slots.begin(), split.parent_slots.end()).size(), 4u);
    for (std::uint8_t card : split.cards) ASSERT_LT(card, 2);
    for (const auto& vertex : split.new_vertices)
      for (std::uint16_t coordinate : vertex) ASSERT_LE(coordinate, COPPICE_QUANTISED_MAX);
  }
}

TEST(PageCodec, EveryTruncationIsRefusedAndAByteMore) {
  const QuantisedTree tree = quantised(40);
  auto page = encoded(tree);
  for (std::size_t length = 0; length < page.size(); ++length)
    EXPECT_FALSE(decoded(tree, std::vector<std::uint8_t>(page.data(), page.data() + length))) << length;
  page.push_back(0);
  EXPECT_STREQ(decoded(tree, page).error().what, "page plain bits");
}

TEST(PageCodec, AFlippedBitGivesAnErrorOrValidSplits) {
  for (std::uint32_t leaf_count : {2u, 40u, 200u}) {
    const QuantisedTree tree = quantised(leaf_count);
    const auto page = encoded(tree);
    for (std::size_t at = 0; at < page.size(); ++at)
      for (int bit = 0; bit < 8; ++bit) {
        std::vector<std::uint8_t> bytes(page.begin(), page.end());
        bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 << bit));
        if (const auto result = decoded(tree, bytes)) expect_valid(*result);
      }
  }
}

TEST(PageCodec, AsksForMatchingSpans) {
  const QuantisedTree tree = quantised(40);
  const auto page = encoded(tree);
  PageScratch scratch;
  DecoderPool decoders;
  std::vector<PageNode> nodes(78);
  PageNode* place = nodes.data();
  std::vector<Split> splits(38);
  const auto result = decode_page(page, {0, 40, 2}, {{tree.nodes.data(), {&place, 1}}, splits}, scratch, decoders);
  EXPECT_EQ(result.error().status, Status::invalid_argument);
}

TEST(Predict, KnownGuesses) {
  page_model::PageHeader header;
  header.shape_count = 2;
  header.shapes[1] = {0, page_model::kShapeOne / 2};  // corner 3 halfway from corner 0 to corner 2
  const page_model::Parent parent = page_model::parent_of({{{0, 0, 0}, {64, 0, 0}, {64, 64, 0}, {0, 64, 0}}});
  EXPECT_EQ(parent.centre, (Point{32, 32, 0}));
  const std::array<Point, 4> quad = {{{100, 100, 100}, {200, 100, 100}, {220, 180, 100}, {}}};
  const page_model::Step fourth{Rule::fourth, 3, 0};
  EXPECT_EQ(page_model::predict(header, 1, fourth, quad, parent), (Point{120, 180, 100}));
  EXPECT_EQ(page_model::predict(header, 3, fourth, quad, parent), (Point{160, 140, 100}));
  EXPECT_EQ(page_model::predict(header, 2, {Rule::first, 1, 0}, quad, parent), (Point{164, 100, 100}));  // parallel to the parent's side
  // 5 / 64 of the way to the parent's corner (64, 0, 0), and 34 / 64 to its centre
  EXPECT_EQ(page_model::predict(header, 0, {Rule::first, 1, 0}, quad, parent), (Point{61, 56, 39}));
}

/// Guesses by the quad, which has no opinion of the parent.
std::uint16_t guessed(const page_model::PageHeader& header, AxisRule rule, const std::array<Point, 4>& quad) {
  const auto [u, v] = page_model::guess_axis(header, rule, kAxisBits, quad, 0);
  return pack_normals(u, v, 15, NormalSide::either);
}

/// In the plane of x and y.
void expect_axis(std::uint16_t normals, float x, float y) {
  const std::array<float, 3> axis = unpack_normals(normals, {}).axis;
  EXPECT_NEAR(axis[0], x, 0.05f);
  EXPECT_NEAR(axis[1], y, 0.05f);
  EXPECT_NEAR(axis[2], 0.0f, 0.05f);
}

TEST(GuessedAxis, IsTheNormalInThePlantNotInTheBox) {
  page_model::PageHeader header;
  header.axis_weights = {65535, 16384, 65535};  // y's steps are half as long as x's and z's
  const auto packed = [&](const std::array<Point, 4>& quad) { return guessed(header, AxisRule::quad, quad); };
  const std::uint16_t slanted = packed({{{0, 0, 0}, {0, 0, 50}, {100, 200, 50}, {100, 200, 0}}});
  expect_axis(slanted, -0.707f, 0.707f);
  EXPECT_EQ(slanted, packed({{{100, 200, 0}, {100, 200, 50}, {0, 0, 50}, {0, 0, 0}}})) << "whichever side the quad turns";
  EXPECT_EQ(packed({{{7, 7, 7}, {7, 7, 7}, {7, 7, 7}, {7, 7, 7}}}), pack_normals(16, 16, 15, NormalSide::either));
  // The farthest corners of the box: no sum overflows.
  constexpr std::int32_t kFar = COPPICE_FINE_QUANTISED_MAX;
  header.axis_weights = {65535, 65535, 65535};
  EXPECT_EQ(packed({{{0, 0, 0}, {kFar, 0, 0}, {kFar, 0, kFar}, {0, 0, kFar}}}), pack_normals(16, 16, 15, NormalSide::either));
  EXPECT_EQ(packed({{{0, 0, 0}, {0, kFar, 0}, {0, kFar, kFar}, {0, 0, kFar}}}), pack_normals(31, 31, 15, NormalSide::either));
  EXPECT_EQ(packed({{{0, 0, 0}, {kFar, 0, 0}, {kFar, kFar, 0}, {0, kFar, 0}}}), pack_normals(31, 1, 15, NormalSide::either));
}

TEST(GuessedAxis, IsTheWayFromStalkToTipInThePlantNotInTheBox) {
  page_model::PageHeader header;
  header.axis_weights = {65535, 16384, 65535};  // y's steps are half as long as x's and z's
  const auto packed = [&](const std::array<Point, 4>& quad) { return guessed(header, AxisRule::spine, quad); };
  const std::uint16_t up_and_along = packed({{{0, 0, 0}, {100, 200, 0}, {100, 200, 50}, {0, 0, 50}}});
  expect_axis(up_and_along, 0.707f, 0.707f);
  EXPECT_EQ(up_and_along, packed({{{100, 200, 0}, {0, 0, 0}, {0, 0, 50}, {100, 200, 50}}})) << "whichever end is the stalk";
  EXPECT_EQ(packed({{{7, 7, 7}, {9, 9, 9}, {7, 7, 7}, {9, 9, 9}}}), pack_normals(16, 16, 15, NormalSide::either));
  constexpr std::int32_t kFar = COPPICE_FINE_QUANTISED_MAX;
  EXPECT_EQ(packed({{{0, 0, 0}, {kFar, 0, 0}, {kFar, 0, 0}, {0, 0, 0}}}), pack_normals(31, 31, 15, NormalSide::either));
}

TEST(Normals, HaveAnAxisAsFineAsTheirAlongTells) {
  for (std::uint32_t along = 0; along <= kAlongSteps; ++along) {
    const std::size_t values = along >= 1 && along <= 9 ? 8 : along <= 12 ? 16 : 32;
    for (const bool is_u : {true, false}) {
      std::size_t held = 0;
      for (std::uint32_t step = 0; step <= kAxisSteps; ++step)
        held += are_normals(pack_normals(is_u ? step : 0, is_u ? 31 : step, along, NormalSide::along)) ? 1u : 0u;
      EXPECT_EQ(held, values) << along;
    }
    EXPECT_TRUE(are_normals(pack_normals(0, kAxisSteps, along, NormalSide::either))) << "both ends";
  }
}

TEST(Shapes, TheCommonOnesAreFound) {
  std::vector<QuantisedQuad> quads;
  for (std::uint16_t i = 0; i < 60; ++i) {
    const auto x = static_cast<std::uint16_t>(100 * i);
    quads.push_back({{{x, 0, 0}, {x, 400, 0}, {static_cast<std::uint16_t>(x + 200), 400, 0}, {static_cast<std::uint16_t>(x + 200), 0, 0}}});
    if (i % 2 == 0) quads.back()[3] = {static_cast<std::uint16_t>(x + 100), 200, 0};  // halfway to corner 2
  }
  const auto shapes = bake::common_shapes(quads);
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0], page_model::kParallelogram);
  EXPECT_NEAR(shapes[1].a, 0, 1);
  EXPECT_NEAR(shapes[1].b, page_model::kShapeOne / 2, 1);
}

// What the fuzz target starts from; COPPICE_UPDATE_GOLDEN=1 writes it anew.
TEST(FuzzCorpus, HoldsPagesOfThisVersion) {
  const std::filesystem::path folder = std::filesystem::path(test::kTestFolder) / "fuzz/corpus/codec";
  constexpr std::uint32_t kPlainLeaves = 30, kShapedLeaves = 60;
  const std::vector<std::pair<std::string, QuantisedTree>> trees = {{"modelled_page_plain", quantised(kPlainLeaves, 1, 3)},
                                                                    {"modelled_page_random", random_splits(kShapedLeaves - 1, 1)}};
  for (const auto& [name, tree] : trees) {
    if (std::getenv("COPPICE_UPDATE_GOLDEN") != nullptr) {
      std::vector<std::uint8_t> bytes{2, 0, 0, static_cast<std::uint8_t>(tree.splits.size() - 1), 0};
      const auto page = encoded(tree);
      bytes.insert(bytes.end(), page.begin(), page.end());
      test::write_file(folder / name, bytes);
    }
    const std::vector<std::uint8_t> bytes = *bake::read_file(folder / name);
    ASSERT_GT(bytes.size(), 5u) << name;
    EXPECT_TRUE(decoded(tree, std::span(bytes).subspan(5), 9)) << name;
  }
}

}  // namespace coppice::page_codec_test
