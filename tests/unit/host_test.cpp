// A host that draws itself, through coppice.h: what it hears, what it confirms, what it is told to draw.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "abi.h"
#include "atomic_file.h"
#include "coppice/coppice.h"
#include "demand.h"
#include "host.h"
#include "mentions.h"
#include "reader.h"
#include "results.h"
#include "select.h"

namespace coppice::test::host_test {

/// A host with one plant, which stands in view.
class HostChanges : public testing::Test {
 protected:
  HostChanges() { host.add(plant, 0, -3); }
  /// Changes of so many frames, those of opening left out.
  std::vector<coppice_change> changes(int frames) {
    std::vector<coppice_change> all;
    for (int i = 0; i < frames; ++i) {
      host.frame();
      for (coppice_change change = host.next(); change.kind != COPPICE_CHANGE_NONE; change = host.next())
        if (change.kind != COPPICE_CHANGE_PLANT_OPENED) all.push_back(change);
    }
    return all;
  }

  void take_frames(int frames) {
    for (int i = 0; i < frames; ++i) {
      host.frame();
      host.take_all();
    }
  }

  Host host;
  coppice_plant plant = host.open("two_pages.coppice");
};

TEST_F(HostChanges, APlantComesChunkByChunkAndGoesAgain) {
  EXPECT_EQ(host.next().kind, COPPICE_CHANGE_PLANT_OPENED);
  host.settle();
  EXPECT_EQ(host.there.size(), 3u) << "two pages and a wood LoD";
  EXPECT_EQ(host.info(plant).resident_leaf_count, 520u);
  coppice_plant_close(host.context(), plant);
  take_frames(4);
  EXPECT_TRUE(host.there.empty());
  EXPECT_EQ(host.files[0], -1) << "closed; that it was opened was taken before";
}

TEST_F(HostChanges, WhatIsNotConfirmedDoesNotCount) {
  std::vector<coppice_change> held;
  std::vector<std::vector<unsigned char>> bytes;  // as they came
  for (int i = 0; i < 50; ++i)
    for (const coppice_change& change : changes(1)) {
      const auto* first = static_cast<const unsigned char*>(change.bytes);
      bytes.emplace_back(first, first + change.byte_count);
      held.push_back(change);
    }
  ASSERT_EQ(held.size(), 2u) << "one page of a plant at a time, and the wood";
  EXPECT_EQ(host.info(plant).resident_leaf_count, 1u);
  ASSERT_EQ(host.draws().size(), 1u);
  EXPECT_EQ(host.draws()[0].leaf_count, 1.0f);
  EXPECT_EQ(host.draws()[0].wood_lod, COPPICE_NONE);
  coppice_plant_close(host.context(), plant);
  for (int i = 0; i < 5; ++i) host.frame();
  EXPECT_EQ(host.next().kind, COPPICE_CHANGE_NONE) << "held chunks keep the file";
  for (std::size_t i = 0; i < held.size(); ++i) {
    EXPECT_EQ(std::memcmp(held[i].bytes, bytes[i].data(), bytes[i].size()), 0) << "bytes stay until they are confirmed";
    EXPECT_EQ(host.confirm(held[i], COPPICE_OUTCOME_TAKEN), COPPICE_OK);
    EXPECT_EQ(host.confirm(held[i], COPPICE_OUTCOME_TAKEN), COPPICE_ERROR_INVALID_ARGUMENT) << "once";
  }
  for (int i = 0; i < 3; ++i) host.frame();
  EXPECT_EQ(host.next().kind, COPPICE_CHANGE_PLANT_CLOSED);
}

TEST_F(HostChanges, WhatFailsIsOfferedAgain) {
  int failed = 0;
  for (int i = 0; i < 200; ++i)
    for (const coppice_change& change : changes(1))
      EXPECT_EQ(host.confirm(change, failed++ < 5 ? COPPICE_OUTCOME_FAILED : COPPICE_OUTCOME_TAKEN), COPPICE_OK);
  EXPECT_GT(failed, 5);
  EXPECT_EQ(host.info(plant).resident_leaf_count, 520u);
}

TEST_F(HostChanges, DroppedMemoryCountsUntilItIsFreed) {
  host.settle();
  const std::uint64_t full_bytes = host.stats().memory_bytes;
  coppice_plant_close(host.context(), plant);
  const std::vector<coppice_change> dropped = changes(20);
  ASSERT_EQ(dropped.size(), 3u);
  const std::uint64_t held_bytes = host.stats().memory_bytes;
  for (const coppice_change& change : dropped) {
    EXPECT_EQ(change.kind, COPPICE_CHANGE_CHUNK_DROPPED);
    EXPECT_EQ(host.confirm(change, COPPICE_OUTCOME_TAKEN), COPPICE_ERROR_INVALID_ARGUMENT);
    EXPECT_EQ(host.confirm(change, COPPICE_OUTCOME_FREED), COPPICE_OK);
  }
  host.frame();
  EXPECT_GT(held_bytes, host.stats().memory_bytes + 520 * 2 * sizeof(coppice_leaf_node)) << "both pages' nodes";
  EXPECT_LT(held_bytes, full_bytes);
  EXPECT_EQ(host.next().kind, COPPICE_CHANGE_PLANT_CLOSED);
}

TEST_F(HostChanges, TheBudgetIsKept) {
  host.settle();
  ASSERT_EQ(coppice_set_memory_budget(host.context(), 63u << 20), COPPICE_OK);
  take_frames(2);  // the instances' lists become shorter: that is no eviction
  const std::uint64_t full_bytes = host.stats().memory_bytes;
  ASSERT_EQ(coppice_set_memory_budget(host.context(), full_bytes - 300), COPPICE_OK) << coppice_last_error(host.context());
  take_frames(10);
  EXPECT_LE(host.stats().memory_bytes, full_bytes - 300);
  EXPECT_EQ(host.info(plant).resident_leaf_count, 513u) << "the second page went";
}

/// The file of a test plant as selection sees it.
struct OpenFile {
  explicit OpenFile(const char* name) {
    bytes = *bake::read_file(kPlants + name);
    file = must(read_front(bytes, bytes.size()));
    words = *pack_lod_table(file, default_allocator());
  }
  std::vector<std::uint8_t> bytes;
  PlantFile file;
  HookArray<std::uint32_t> words;
};

TEST(HostDraws, AreWhatSelectionSaysOfWhatIsInView) {
  Host host;
  host.camera().error_px = 0.7f;
  const coppice_plant plant = host.open("two_pages.coppice");
  const OpenFile open("two_pages.coppice");
  std::vector<InstanceSphere> spheres;
  std::vector<coppice_instance> handles;
  for (int i = 0; i < 700; ++i) {
    const auto x = static_cast<float>(i % 30 - 15), z = static_cast<float>(2 - i / 30);
    const float scale = 0.5f + 0.01f * static_cast<float>(i % 100);
    handles.push_back(host.add(plant, x, z, scale));
    const coppice_file_plant& of = open.file.plant;
    spheres.push_back({dvec3(vec3(x, -1, z) + vec3(of.sphere_center) * scale), of.sphere_radius * scale, 0});
  }
  host.settle();
  const LodView view = *demand_view(host.camera());
  const LodPlant lod_plant{lod_table(open.file, open.words.span()), host.info(plant).resident_leaf_count, 1, false};
  std::vector<InstanceLod> lods(spheres.size());
  select_lods(spheres, {&lod_plant, 1}, view, lods);
  const std::vector<coppice_draw> draws = host.draws();
  std::map<coppice_instance, const coppice_draw*> by_instance;  // in no order: the library sorts instances
  for (const coppice_draw& draw : draws) by_instance[draw.instance] = &draw;
  std::size_t next = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const bool in_view = std::ranges::all_of(view.eyes[0].planes, [&](const vec4& plane) {
      return dot(plane.xyz(), (spheres[i].center_m - view.eye_m).rounded()) + plane.w >= -spheres[i].radius_m;
    });
    if (!in_view) continue;
    ASSERT_TRUE(by_instance.contains(handles[i])) << i;
    const coppice_draw& draw = *by_instance[handles[i]];
    ++next;
    EXPECT_EQ(draw.plant, plant);
    EXPECT_EQ(draw.leaf_count, lods[i].leaf_count);
    EXPECT_EQ(draw.wood_lod, lods[i].wood_lod);
    EXPECT_EQ(draw.node_end, 2 * lod::coppice_whole_leaf_count(lods[i].leaf_count) - 1);
  }
  EXPECT_EQ(next, draws.size());
  EXPECT_GT(next, 100u);
  EXPECT_LT(next, 600u);

  constexpr std::size_t kWide = sizeof(coppice_draw) + 16;
  std::vector<unsigned char> wide(3 * kWide, 0xee);
  std::uint32_t count = 0;
  EXPECT_EQ(coppice_get_draws(host.context(), host.view(), reinterpret_cast<coppice_draw*>(wide.data()), 2, kWide, &count), COPPICE_OK);
  EXPECT_EQ(count, draws.size());
  EXPECT_EQ(std::memcmp(wide.data() + kWide, &draws[1], sizeof draws[1]), 0);
  EXPECT_EQ(wide[kWide + sizeof(coppice_draw)], 0);
  EXPECT_EQ(wide[2 * kWide], 0xee);
}

TEST(HostDraws, AreSmallerWhileTheyFadeIn) {
  Host host;
  const coppice_plant plant = host.open("two_pages.coppice");
  const coppice_instance stays = host.add(plant, 1, -3, 2.0f);
  host.settle();
  const coppice_instance comes = host.add(plant, 0, -3, -2.0f);
  const auto fade_in = [&](std::uint32_t frames) { return coppice_instances_fade_in(host.context(), &comes, 1, frames); };
  EXPECT_EQ(fade_in(0), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(fade_in(256), COPPICE_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(fade_in(4), COPPICE_OK) << coppice_last_error(host.context());
  for (const float scale : {-0.5f, -1.0f, -1.5f, -2.0f, -2.0f}) {
    host.frame();
    std::uint32_t settled = 0;
    EXPECT_EQ(coppice_is_settled(host.context(), host.view(), &settled), COPPICE_OK);
    EXPECT_EQ(settled, scale == -2.0f ? COPPICE_TRUE : COPPICE_FALSE);
    for (const coppice_draw& draw : host.draws()) EXPECT_EQ(draw.scale, draw.instance == stays ? 2.0f : scale);
  }
  ASSERT_EQ(coppice_instances_remove(host.context(), &comes, 1), COPPICE_OK);
  const std::array both{stays, comes};
  EXPECT_EQ(coppice_instances_fade_in(host.context(), both.data(), 2, 4), COPPICE_ERROR_INVALID_ARGUMENT);
  host.frame();
  ASSERT_EQ(host.draws().size(), 1u);
  EXPECT_EQ(host.draws()[0].scale, 2.0f) << "none fades in";
}

TEST(HostDraws, HaveWhatWindMayMoveIntoView) {
  Host host;
  const coppice_plant plant = host.open("two_pages.coppice");
  const OpenFile open("two_pages.coppice");
  const coppice_file_plant& of = open.file.plant;
  // The right plane is at 45 degrees; the sphere ends beyond it by a fiftieth of its radius.
  const float x = 50.0f + 1.02f * std::sqrt(2.0f) * of.sphere_radius - of.sphere_center[0], z = -50.0f - of.sphere_center[2];
  host.add(plant, x, z);
  host.settle();
  EXPECT_EQ(host.draws().size(), 0u);
  auto wind = struct_defaults<coppice_wind>();
  wind.speed = 25.0f;
  host.wind = &wind;
  host.frame();
  EXPECT_EQ(host.draws().size(), 1u);
  wind.speed = 1.0f;  // not so far
  host.frame();
  EXPECT_EQ(host.draws().size(), 0u);
  std::array<float, 8> map;
  map.fill(20.0f);
  wind.map = map.data();
  wind.map_width = wind.map_height = 2;
  wind.map_max[0] = wind.map_max[1] = 1.0;
  host.frame();
  EXPECT_EQ(host.draws().size(), 1u) << "a map may blow it there";
}

TEST(HostDraws, OfAPairAreThoseThatEitherEyeSees) {
  Host host;
  host.camera().error_px = 0.7f;
  const coppice_plant plant = host.open("two_pages.coppice");
  for (int i = 0; i < 700; ++i) host.add(plant, static_cast<float>(i % 30 - 15), static_cast<float>(10 - i / 30));
  host.settle();
  auto second = struct_defaults<coppice_eye>();
  std::copy_n(host.camera().clip_from_view, 16, second.clip_from_view);
  second.view_from_world[0] = second.view_from_world[10] = -1.0;  // backwards
  second.view_from_world[12] = 0.2;
  const auto instances_seen = [&] {
    host.frame();
    std::set<coppice_instance> seen;
    for (const coppice_draw& draw : host.draws()) seen.insert(draw.instance);
    return seen;
  };
  std::set<coppice_instance> either = instances_seen();
  const std::size_t first_count = either.size();
  host.camera().second_eye = &second;
  const std::set<coppice_instance> of_pair = instances_seen();
  host.camera().second_eye = nullptr;
  std::copy_n(second.view_from_world, 16, host.camera().view_from_world);
  either.merge(instances_seen());
  EXPECT_EQ(of_pair, either);
  EXPECT_GT(either.size(), first_count + 50);
}

struct Vertex {
  std::uint32_t material;
  float uv[2];
  std::uint8_t color[4];
  float normal[3];
  float position[3];
  std::uint32_t own;
};

/// The tree of file 0, whose pages are all there.
struct HostTree {
  coppice_file_info info = struct_defaults<coppice_file_info>();
  std::vector<coppice_leaf_node> nodes;
  std::vector<std::uint32_t> splits;  ///< [nodes]

  explicit HostTree(Host& host) {
    EXPECT_EQ(coppice_file_get_info(host.context(), 0, &info), COPPICE_OK);
    nodes = {info.root};
    nodes.insert(nodes.end(), host.nodes.begin(), host.nodes.end());
    for (const coppice_leaf_node& node : nodes) splits.push_back(node.split);
  }
};

/// Where so many leaves go. Vertices and indices must be as long.
template <class V, class I>
coppice_leaf_output output_into(std::vector<V>& vertices, std::vector<I>& indices, std::uint32_t leaf_count) {
  auto output = struct_defaults<coppice_leaf_output>();
  output.vertices = vertices.data();
  output.indices = indices.data();
  output.vertex_capacity = 4 * leaf_count;
  output.index_capacity = 6 * leaf_count;
  return output;
}

TEST(WriteLeaves, AreTheCutInAnyLayout) {
  Host host;
  host.add(host.open("two_pages.coppice"), 0, -3);
  host.settle();
  const auto [info, nodes, splits] = HostTree(host);

  auto layout = struct_defaults<coppice_leaf_layout>();
  layout.vertex_bytes = sizeof(Vertex);
  layout.material = offsetof(Vertex, material);
  layout.uv = offsetof(Vertex, uv);
  layout.color = offsetof(Vertex, color);
  layout.color_format = COPPICE_LEAF_COLOR_UNORM8X4;
  layout.normal = offsetof(Vertex, normal);
  layout.position = offsetof(Vertex, position);
  layout.index_bytes = 2;
  for (const float leaf_count : {1.0f, 2.0f, 17.4f, 512.0f, 513.0f, 514.0f, 520.0f, 9999.0f}) {
    SCOPED_TRACE(leaf_count);
    const std::uint32_t whole = std::min(lod::coppice_whole_leaf_count(leaf_count), 520u);
    std::vector<std::uint32_t> cut(whole);
    ASSERT_EQ(select_cut(splits, whole, cut), whole);
    std::vector<Vertex> vertices(4 * whole + 1, Vertex{.own = 77});
    std::vector<std::uint16_t> indices(6 * whole + 1, 0xeeee);
    auto output = struct_defaults<coppice_leaf_output>();
    ASSERT_EQ(coppice_write_leaves(host.context(), 0, leaf_count, &layout, &output), COPPICE_OK);
    ASSERT_EQ(output.vertex_count, 4 * whole);
    output = output_into(vertices, indices, whole);
    ASSERT_EQ(coppice_write_leaves(host.context(), 0, leaf_count, &layout, &output), COPPICE_OK) << coppice_last_error(host.context());
    EXPECT_EQ(output.leaf_count, whole);
    for (std::uint32_t i = 0; i < whole; ++i) {
      const coppice_leaf_node& node = nodes[cut[i]];
      auto card = struct_defaults<coppice_card>();
      ASSERT_EQ(coppice_file_get_card(host.context(), 0, node.card, &card), COPPICE_OK);
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const Vertex& vertex = vertices[4 * i + corner];
        for (std::size_t axis = 0; axis < 3; ++axis)
          ASSERT_EQ(vertex.position[axis], info.box_min[axis] + info.box_step[axis] * static_cast<float>(node.corners[corner][axis]));
        ASSERT_EQ(std::memcmp(vertex.uv, card.uv[corner], sizeof vertex.uv), 0);
        ASSERT_EQ(vertex.material, card.material);
        ASSERT_EQ(vertex.own, 77u);
        ASSERT_EQ(vertex.color[3], (255 * node.opacity + 8) / 16);
      }
      ASSERT_EQ(indices[6 * i + 5], 4 * i + 3);
    }
    EXPECT_EQ(indices[6 * whole], 0xeeee);
    EXPECT_EQ(vertices[4 * whole].position[0], 0.0f);
  }

  std::vector<float> positions(3 * 4 * 20);
  std::vector<std::uint32_t> indices(6 * 20);
  layout = struct_defaults<coppice_leaf_layout>();
  layout.vertex_bytes = 12;
  layout.position = 0;
  coppice_leaf_output output = output_into(positions, indices, 20);
  ASSERT_EQ(coppice_write_leaves(host.context(), 0, 20.0f, &layout, &output), COPPICE_OK);
  EXPECT_EQ(indices[119], 79u);
  layout.normal = 4;
  EXPECT_EQ(coppice_write_leaves(host.context(), 0, 20.0f, &layout, &output), COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(mentions(coppice_last_error(host.context()), {"coppice_write_leaves: layout.normal", "4", "12", "vertex_bytes"}));
}

// The normals of every kind of node, computed from the node's bits as coppice_leaf_node says.
TEST(WriteLeaves, AreLitAsTheirNodesSay) {
  Host host;
  host.add(host.open("noisy_looks.coppice"), 0, -3);
  host.settle();
  const auto [info, nodes, splits] = HostTree(host);

  struct Lit {
    std::array<float, 3> normal;
    float along, sided;
  };
  auto layout = struct_defaults<coppice_leaf_layout>();
  layout.vertex_bytes = sizeof(Lit);
  layout.normal = offsetof(Lit, normal);
  layout.along = offsetof(Lit, along);
  layout.sided = offsetof(Lit, sided);
  std::array<std::uint32_t, 4> sides{};
  for (std::uint32_t leaf_count = 1; leaf_count <= 70; ++leaf_count) {
    std::vector<std::uint32_t> cut(leaf_count);
    ASSERT_EQ(select_cut(splits, leaf_count, cut), leaf_count);
    std::vector<Lit> vertices(4 * std::size_t{leaf_count});
    std::vector<std::uint32_t> indices(6 * std::size_t{leaf_count});
    coppice_leaf_output output = output_into(vertices, indices, leaf_count);
    ASSERT_EQ(coppice_write_leaves(host.context(), 0, static_cast<float>(leaf_count), &layout, &output), COPPICE_OK);
    for (std::uint32_t i = 0; i < leaf_count; ++i) {
      const coppice_leaf_node& node = nodes[cut[i]];
      SCOPED_TRACE(cut[i]);
      std::array<std::array<double, 3>, 2> d{};  // the quad's diagonals
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t k = 0; k < 2; ++k)
          d[k][axis] = static_cast<double>(info.box_step[axis]) * (node.corners[k + 2][axis] - node.corners[k][axis]);
      const std::array<double, 3> face = {d[0][1] * d[1][2] - d[0][2] * d[1][1], d[0][2] * d[1][0] - d[0][0] * d[1][2],
                                          d[0][0] * d[1][1] - d[0][1] * d[1][0]};
      const int side = node.normals >> 14;
      ++sides[static_cast<std::size_t>(side)];
      const int k15 = node.normals >> 10 & 15, bits = k15 >= 1 && k15 <= 9 ? 3 : k15 <= 12 ? 4 : 5, half = 1 << (bits - 1);
      const auto share = [&](int step) { return std::max((static_cast<double>(step >> (5 - bits)) - half) / (half - 1), -1.0); };
      const double u = share(node.normals & 31), v = share(node.normals >> 5 & 31), x = (u + v) / 2, z = (u - v) / 2;
      std::array<double, 3> axis = {x, 1 - std::abs(x) - std::abs(z), z};
      if (side == 3) axis = face;
      const double above = axis[0] * face[0] + axis[1] * face[1] + axis[2] * face[2];
      const double sign = side == 2 || (side == 0 && above < 0) ? -1 : 1, length = std::hypot(axis[0], axis[1], axis[2]);
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const Lit& vertex = vertices[4 * std::size_t{i} + corner];
        for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(vertex.normal[k], sign * axis[k] / length, 1e-4);
        EXPECT_NEAR(vertex.along, side == 3 ? 1.0 : (node.normals >> 10 & 15) / 15.0, 1e-6);
        EXPECT_EQ(vertex.sided, side == 1 || side == 2 ? 1.0f : 0.0f);
      }
    }
  }
  for (const std::uint32_t count : sides) EXPECT_GT(count, 70u);
}

}  // namespace coppice::test::host_test
