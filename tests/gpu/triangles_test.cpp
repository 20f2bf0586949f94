// coppice_record_triangles: what the GPU writes is what coppice_write_leaves says of the same cut, and the plant's meshes.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <vector>

#include "path_fixture.h"

namespace coppice::test::triangles_test {

using Corners = std::array<float, 9>;

class TrianglesTest : public PathTest<ContextTest> {
 protected:
  /// After a frame that shows the plant near.
  std::vector<Corners> record(coppice_triangles& answer) {
    constexpr std::size_t kCapacity = 20000;
    const Buffer buffer(gpu(), kCapacity * sizeof(Corners), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    std::memset(buffer.mapped(), 0xff, buffer.bytes());
    answer.positions = buffer.address();
    answer.triangle_capacity = kCapacity;
    answer.triangle_count = 0;
    Shot shot = make_view({.eye_m = {0.5f, 1.0f, 2.5f}});
    shot.error_px = 0.01f;  // everything is loaded
    for (int i = 0; i < 400 && (answer.triangle_count == 0 || !is_settled(view_)); ++i) {
      usleep(1000);
      frame_with(shot, [&](VkCommandBuffer cmd) {
        EXPECT_EQ(coppice_record_triangles(context_, cmd, plant_, &answer), COPPICE_OK) << log_;
        full_barrier(cmd);
      });
    }
    std::vector<Corners> all(kCapacity);
    std::memcpy(all.data(), buffer.mapped(), buffer.bytes());
    const auto is_written = [](const Corners& corners) {
      return std::ranges::none_of(corners, [](float number) { return number != number; });
    };
    EXPECT_TRUE(std::all_of(all.begin(), all.begin() + answer.triangle_count, is_written));
    EXPECT_TRUE(std::none_of(all.begin() + answer.triangle_count, all.end(), is_written)) << "written beyond the count";
    all.resize(answer.triangle_count);
    return all;
  }

  /// The cut's triangles by the CPU.
  std::vector<Corners> written(std::uint32_t leaf_count) {
    auto layout = defaults(coppice_leaf_layout_init);
    layout.vertex_bytes = 12;
    layout.position = 0;
    std::vector<std::array<float, 3>> vertices(std::size_t{4} * leaf_count);
    std::vector<std::uint32_t> indices(std::size_t{6} * leaf_count);
    auto output = defaults(coppice_leaf_output_init);
    output.vertices = vertices.data();
    output.vertex_capacity = static_cast<std::uint32_t>(vertices.size());
    output.indices = indices.data();
    output.index_capacity = static_cast<std::uint32_t>(indices.size());
    EXPECT_EQ(coppice_write_leaves(context_, 0, static_cast<float>(leaf_count), &layout, &output), COPPICE_OK) << log_;
    EXPECT_EQ(output.leaf_count, leaf_count);
    std::vector<Corners> triangles(indices.size() / 3);
    for (std::size_t i = 0; i < indices.size(); ++i) std::ranges::copy(vertices[indices[i]], triangles[i / 3].begin() + 3 * (i % 3));
    return triangles;
  }
};

TEST_P(TrianglesTest, ACutIsThatOfTheCpu) {
  add(plant_, placement_at(glm::vec3(0)));
  auto asked = defaults(coppice_triangles_init);
  for (const float leaf_count : {1.0f, 5.0f, 64.0f, 65.0f, 700.0f, 1800.5f, 3000.0f, 1e9f}) {
    asked.leaf_count = leaf_count;
    std::vector<Corners> triangles = record(asked);
    const std::uint32_t leaves = asked.triangle_count / 2;
    EXPECT_GE(static_cast<float>(leaves), std::min(leaf_count, 3000.0f));
    EXPECT_LE(static_cast<float>(leaves), leaf_count <= 64.0f ? 1.2f * leaf_count : std::min(leaf_count + 1.0f, 3000.0f));
    std::vector<Corners> expected = written(leaves);
    // The order is that of clusters. Both sides round, so each triangle looks for one that is as good as equal.
    const auto is_same = [](const Corners& a, const Corners& b) {
      return std::ranges::equal(a, b, [](float x, float y) { return std::abs(x - y) < 1e-5f; });
    };
    ASSERT_EQ(triangles.size(), expected.size());
    for (const Corners& triangle : triangles) {
      const auto same = std::ranges::find_if(expected, [&](const Corners& other) { return is_same(triangle, other); });
      ASSERT_NE(same, expected.end()) << leaf_count << " leaves";
      *same = expected.back();
      expected.pop_back();
    }
  }
}

TEST_P(TrianglesTest, WoodComesAfterLeavesAndTheSameCutHasTheSameBytes) {
  add(plant_, placement_at(glm::vec3(0)));
  auto asked = defaults(coppice_triangles_init);
  asked.leaf_count = 700.0f;
  const std::vector<Corners> leaves = record(asked);
  asked.wood_lod = 0;
  const std::vector<Corners> both = record(asked);
  ASSERT_GT(both.size(), leaves.size());
  EXPECT_TRUE(std::equal(leaves.begin(), leaves.end(), both.begin()));
  asked.leaf_count = 0.0f;
  const std::vector<Corners> wood = record(asked);
  EXPECT_TRUE(std::equal(wood.end() - static_cast<std::ptrdiff_t>(both.size() - leaves.size()), wood.end(),
                         both.begin() + static_cast<std::ptrdiff_t>(leaves.size())));
}

TEST_P(TrianglesTest, TooSmallACapacityWritesNothingAndSaysWhatIsNeeded) {
  add(plant_, placement_at(glm::vec3(0)));
  auto asked = defaults(coppice_triangles_init);
  asked.leaf_count = 700.0f;
  const std::size_t needed = record(asked).size();
  auto small = defaults(coppice_triangles_init);
  small.leaf_count = 700.0f;
  const Shot shot = make_view({.eye_m = {0.5f, 1.0f, 2.5f}});
  frame_with(shot, [&](VkCommandBuffer cmd) { EXPECT_EQ(coppice_record_triangles(context_, cmd, plant_, &small), COPPICE_OK); });
  EXPECT_EQ(small.triangle_count, needed);
  small.positions = 6;
  frame_with(shot, [&](VkCommandBuffer cmd) {
    EXPECT_EQ(coppice_record_triangles(context_, cmd, plant_, &small), COPPICE_ERROR_INVALID_ARGUMENT);
  });
}

INSTANTIATE_TEST_SUITE_P(Paths, TrianglesTest, testing::Values(kHardwarePath), path_name);

}  // namespace coppice::test::triangles_test
