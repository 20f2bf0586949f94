#include "normal_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "block_texture.h"
#include "reader.h"
#include "results.h"
#include "texture_encode.h"

namespace coppice::bake::normal_map_test {

/// Waves of a slope of up to 1 along both axes.
Image waves(std::uint32_t width, std::uint32_t height) {
  Image map{width, height, std::vector<std::uint8_t>(std::size_t{width} * height * 4), true};
  for (std::size_t i = 0; i < map.rgba.size() / 4; ++i) {
    const auto x = static_cast<float>(i % width), y = static_cast<float>(i / width);
    write_normal({std::sin(0.21f * x), std::cos(0.17f * y), 1.0f}, std::span<std::uint8_t, 4>(map.rgba.data() + 4 * i, 4));
  }
  return map;
}

glm::vec3 normal_at(const Image& map, std::size_t texel) {
  return normal_of(std::span<const std::uint8_t, 4>(map.rgba.data() + 4 * texel, 4));
}

/// Degrees between the normals of two maps, the largest.
float worst_angle_deg(const Image& a, const Image& b) {
  float min_cosine = 1.0f;
  for (std::size_t i = 0; i < a.rgba.size() / 4; ++i)
    min_cosine = std::min(min_cosine, glm::dot(glm::normalize(normal_at(a, i)), glm::normalize(normal_at(b, i))));
  return std::acos(std::min(1.0f, min_cosine)) * 57.29578f;
}

float mean_angle_deg(const Image& a, const Image& b) {
  float sum = 0.0f;
  const std::size_t texels = a.rgba.size() / 4;
  for (std::size_t i = 0; i < texels; ++i)
    sum += std::acos(std::min(1.0f, glm::dot(glm::normalize(normal_at(a, i)), glm::normalize(normal_at(b, i)))));
  return sum / static_cast<float>(texels) * 57.29578f;
}

TEST(NormalMap, TexelsHoldUnitVectorsThatLookOut) {
  std::array<std::uint8_t, 4> texel{};
  write_normal({0.0f, 0.0f, 7.0f}, texel);
  EXPECT_EQ(texel, (std::array<std::uint8_t, 4>{128, 128, 255, 255}));
  write_normal({3.0f, 0.0f, 4.0f}, texel);
  EXPECT_EQ(texel, (std::array<std::uint8_t, 4>{204, 128, 230, 255})) << "0.6, 0, 0.8";
  for (const glm::vec3& none : {glm::vec3(0.0f), glm::vec3(1.0f, 0.0f, -0.5f)}) {
    write_normal(none, texel);
    EXPECT_EQ(texel, (std::array<std::uint8_t, 4>{128, 128, 255, 255}));
  }
}

TEST(NormalMap, ALevelIsTheDirectionOfTheSum) {
  Image map{2, 1, std::vector<std::uint8_t>(8), true};
  write_normal({0.6f, 0.0f, 0.8f}, std::span<std::uint8_t, 4>(map.rgba.data(), 4));
  write_normal({0.0f, 0.6f, 0.8f}, std::span<std::uint8_t, 4>(map.rgba.data() + 4, 4));
  const std::vector<Image> levels = normal_map_levels(map);
  ASSERT_EQ(levels.size(), 2u);
  const glm::vec3 mean = glm::normalize(glm::vec3(0.6f, 0.6f, 1.6f)), found = normal_at(levels[1], 0);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(found[axis], mean[axis], 0.01f);
}

TEST(NormalMap, EveryTexelOfAnOddSideCounts) {
  Image map = waves(3, 1);
  write_normal({1.0f, 0.0f, 0.2f}, std::span<std::uint8_t, 4>(map.rgba.data() + 8, 4));
  const glm::vec3 sum = normal_at(map, 0) + normal_at(map, 1) + normal_at(map, 2);
  EXPECT_LT(glm::distance(normal_at(normal_map_levels(map)[1], 0), glm::normalize(sum)), 0.02f);
}

TEST(NormalMap, ComesBackFromItsStoredForm) {
  const Image map = waves(61, 34), back = normal_map_from_stored(stored_normal_map(map));
  EXPECT_TRUE(back.is_normal_map);
  EXPECT_LT(worst_angle_deg(map, back), 2.0f);
}

TEST(NormalMap, BlocksStayWithinAFewDegrees) {
  const Image map = waves(64, 64);
  const auto chunk = test::must(encode_texture(map, 0.0f, TextureCoding::bc));
  const auto layout = test::must(read_texture(chunk));
  EXPECT_EQ(layout.format, std::uint32_t{COPPICE_TEXTURE_BC3});
  const std::vector<Image> levels = normal_map_levels(map);
  ASSERT_EQ(layout.levels().size(), levels.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const MipLevel& level = layout.levels()[i];
    Image stored{level.width, level.height, std::vector<std::uint8_t>(std::size_t{level.width} * level.height * 4)};
    decode_texture_level(layout.format, level, std::span(chunk).subspan(level.offset, level.bytes), stored.rgba);
    EXPECT_LT(mean_angle_deg(levels[i], normal_map_from_stored(stored)), 5.0f) << i;
  }
}

}  // namespace coppice::bake::normal_map_test
