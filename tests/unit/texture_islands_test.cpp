// Plants whose leaves, bark and decorations share one picture: whatever lies between them in it, what each part shows keeps its mean colour
// at every mip level, as the area of its triangles weighs it.

#include <gtest/gtest.h>
#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "material_split.h"
#include "polygons.h"
#include "srgb.h"
#include "texture_mips.h"
#include "texture_regions.h"
#include "texture_shown.h"

namespace coppice::bake::texture_islands_test {

using Rgba = std::array<std::uint8_t, 4>;
constexpr std::uint32_t kSide = 256;

Image paint(const std::function<Rgba(std::uint32_t, std::uint32_t)>& texel) {
  Image image{kSide, kSide, {}};
  for (std::uint32_t y = 0; y < kSide; ++y)
    for (std::uint32_t x = 0; x < kSide; ++x)
      for (const std::uint8_t channel : texel(x, y)) image.rgba.push_back(channel);
  return image;
}

/// In texels; drawn as large as it is in the picture, times `scale`.
void add_rectangle(Mesh& mesh, std::uint32_t material, const glm::vec2& low, const glm::vec2& high, float scale = 1.0f) {
  std::array<glm::vec2, 4> uvs{low, glm::vec2(high.x, low.y), high, glm::vec2(low.x, high.y)};
  std::array<glm::vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = glm::vec3(uvs[i] * scale, 0.0f);
  for (glm::vec2& uv : uvs) uv /= static_cast<float>(kSide);
  test::add_polygon(mesh, corners, uvs, material);
}

void add_leaf(Plant& plant, std::uint32_t material, const glm::vec2& low, const glm::vec2& high, float scale = 1.0f) {
  plant.leaves.push_back({static_cast<std::uint32_t>(plant.foliage.triangle_materials.size()), 2});
  add_rectangle(plant.foliage, material, low, high, scale);
}

/// Bilinear, repeating, in linear light: what a sampler returns.
glm::dvec4 sampled(const Image& level, const glm::dvec2& uv) {
  const glm::dvec2 at = uv * glm::dvec2(level.width, level.height) - 0.5;
  const glm::dvec2 low = glm::floor(at), part = at - low;
  glm::dvec4 sum(0.0);
  for (int corner = 0; corner < 4; ++corner) {
    const auto wrap = [](double texel, std::uint32_t side) {
      const auto period = static_cast<std::int64_t>(side);
      return static_cast<std::size_t>((static_cast<std::int64_t>(texel) % period + period) % period);
    };
    const std::size_t x = wrap(low.x + corner % 2, level.width), y = wrap(low.y + corner / 2, level.height);
    const std::uint8_t* rgba = level.rgba.data() + 4 * (y * level.width + x);
    const double weight = (corner % 2 == 1 ? part.x : 1.0 - part.x) * (corner / 2 == 1 ? part.y : 1.0 - part.y);
    const auto linear = [&](int c) { return static_cast<double>(linear_from_srgb(static_cast<float>(rgba[c]) / 255.0f)); };
    sum += weight * glm::dvec4(linear(0), linear(1), linear(2), rgba[3] / 255.0);
  }
  return sum;
}

using Sampler = std::function<glm::dvec4(std::uint32_t material, const glm::dvec2& uv)>;

/// Mean colour of triangles [first, last), of what the alpha test keeps.
glm::dvec3 mean_color(const Plant& plant, const Mesh& mesh, std::size_t first, std::size_t last, const Sampler& sample) {
  constexpr int kSteps = 48;
  glm::dvec3 sum(0.0);
  double area = 0.0;
  for (std::size_t t = first; t < last; ++t) {
    const UvTriangle uvs = triangle_uvs(mesh, t);
    const double share = triangle_area_m2(mesh, t) / (kSteps * (kSteps + 1) / 2);
    const std::uint32_t material = mesh.triangle_materials[t];
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j + i < kSteps; ++j) {
        const double u = (i + 1.0 / 3) / kSteps, v = (j + 1.0 / 3) / kSteps;
        const glm::dvec4 texel = sample(material, (1 - u - v) * glm::dvec2(uvs[0]) + u * glm::dvec2(uvs[1]) + v * glm::dvec2(uvs[2]));
        if (texel.a < static_cast<double>(plant.materials[material].alpha_cutoff)) continue;
        sum += share * glm::dvec3(texel) * glm::dvec3(plant.materials[material].base_color);
        area += share;
      }
  }
  EXPECT_GT(area, 0.0) << "all of it is holes";
  return sum / area;
}

/// Some triangles of a mesh that are seen as one thing.
struct Part {
  std::string name;
  bool is_wood = false;
  std::size_t first = 0, last = 0;
};

/// Each part's mean at every mip level against what it shows of the picture as it was painted, to 2 % of its brightest channel.
void expect_means_kept(const Plant& source, const std::vector<Part>& parts) {
  Plant plant = source;
  split_materials(plant);
  cut_texture_regions(plant);
  std::vector<std::vector<Image>> levels;
  std::size_t level_count = 0;
  for (const Image& image : plant.images) {
    float cutoff = 0.0f;
    for (const Material& material : plant.materials)
      if (&plant.images[material.image] == &image) cutoff = material.alpha_cutoff;
    levels.push_back(mip_levels(image, cutoff));
    level_count = std::max(level_count, levels.back().size());
  }
  for (const Part& part : parts) {
    const auto mesh_of = [&](const Plant& of) -> const Mesh& { return part.is_wood ? of.wood : of.foliage; };
    const glm::dvec3 expected =
        mean_color(source, mesh_of(source), part.first, part.last, [&](std::uint32_t material, const glm::dvec2& uv) {
          const Image& image = source.images[source.materials[material].image];
          const glm::dvec2 texel = glm::floor((uv - glm::floor(uv)) * static_cast<double>(kSide));
          return sampled(image, (texel + 0.5) / static_cast<double>(kSide));
        });
    const double tolerance = 0.02 * std::max({expected.r, expected.g, expected.b});
    for (std::size_t level = 0; level < level_count; ++level) {
      const glm::dvec3 mean = mean_color(plant, mesh_of(plant), part.first, part.last, [&](std::uint32_t material, const glm::dvec2& uv) {
        const std::vector<Image>& of_image = levels[plant.materials[material].image];
        return sampled(of_image[std::min(level, of_image.size() - 1)], uv);
      });
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], expected[c], tolerance) << part.name << ", level " << level << ", channel " << c;
    }
  }
}

/// Ornament of two tones, so that a mean is a mean of something.
Rgba striped(std::uint32_t x, std::uint32_t y, const Rgba& color) {
  Rgba result = color;
  for (std::size_t c = 0; c < 3; ++c) result[c] = static_cast<std::uint8_t>(color[c] + ((x / 3 + y / 5) % 2 == 0 ? 8 : -8));
  return result;
}

constexpr Rgba kGreen{40, 110, 30, 255}, kBark{90, 60, 40, 255}, kYellow{240, 200, 20, 255};
const std::vector<Rgba> kPapers{{255, 255, 255, 255}, {0, 0, 0, 255}, {255, 0, 255, 255}};

Rgba leaf_bark_and_bauble(std::uint32_t x, std::uint32_t y, const Rgba& paper) {
  if (x >= 20 && x < 90 && y >= 30 && y < 230) return striped(x, y, kGreen);
  if (x >= 117 && x < 160 && y >= 5 && y < 250) return striped(x, y, kBark);
  if (x >= 200 && x < 231 && y >= 100 && y < 131) return striped(x, y, kYellow);
  return paper;
}

TEST(TextureIslands, OneMaterialWithLeavesBarkAndBaublesKeepsTheColourOfEach) {
  for (const Rgba& paper : kPapers) {
    Plant plant;
    plant.materials = {{.name = "all", .image = 0}};
    plant.images = {paint([&](std::uint32_t x, std::uint32_t y) { return leaf_bark_and_bauble(x, y, paper); })};
    for (int i = 0; i < 6; ++i) add_leaf(plant, 0, {20.0f, 30.0f}, {90.0f, 230.0f});
    add_rectangle(plant.wood, 0, {117.0f, 5.0f}, {160.0f, 250.0f});
    add_rectangle(plant.wood, 0, {200.0f, 100.0f}, {231.0f, 131.0f});
    expect_means_kept(plant, {{"leaves", false, 0, 12}, {"bark", true, 0, 2}, {"bauble", true, 2, 4}});
  }
}

TEST(TextureIslands, MaterialsWithIslandsAllOverOneImageKeepTheirColours) {
  // Squares of 16 texels like a chess board's, leaves on the white ones; no region holds one kind alone.
  const auto is_leaf = [](std::uint32_t x, std::uint32_t y) { return (x / 32 + y / 32) % 2 == 0; };
  Plant plant;
  plant.materials = {{.name = "leaf", .image = 0}, {.name = "bark", .image = 0}};
  plant.images = {paint([&](std::uint32_t x, std::uint32_t y) {
    const bool island = x % 32 >= 8 && x % 32 < 24 && y % 32 >= 8 && y % 32 < 24;
    return !island ? Rgba{255, 255, 255, 255} : striped(x, y, is_leaf(x, y) ? kGreen : kBark);
  })};
  for (std::uint32_t y = 0; y < kSide; y += 32)
    for (std::uint32_t x = 0; x < kSide; x += 32) {
      const glm::vec2 low(static_cast<float>(x) + 8.0f, static_cast<float>(y) + 8.0f);
      if (is_leaf(x, y))
        add_leaf(plant, 0, low, low + 16.0f);
      else
        add_rectangle(plant.wood, 1, low, low + 16.0f);
    }
  expect_means_kept(plant, {{"leaves", false, 0, 64}, {"bark", true, 0, 64}});
}

TEST(TextureIslands, MaskedLeavesKeepTheirColourOverAnyHole) {
  for (const Rgba& paper : kPapers)
    for (const std::uint8_t faint : {std::uint8_t{0}, std::uint8_t{90}}) {  // alphas that the alpha test discards
      Plant plant;
      plant.materials = {{.name = "leaf", .image = 0, .alpha_cutoff = 0.5f}};
      plant.images = {paint([&](std::uint32_t x, std::uint32_t y) -> Rgba {
        const double dx = x + 0.5 - 128.0, dy = y + 0.5 - 128.0;
        if (std::hypot(dx, 2.0 * dy) < 110.0 && (x / 7) % 3 != 0) return striped(x, y, kGreen);
        return {paper[0], paper[1], paper[2], faint};
      })};
      for (int i = 0; i < 3; ++i) add_leaf(plant, 0, {0.0f, 0.0f}, {256.0f, 256.0f});
      expect_means_kept(plant, {{"leaves", false, 0, 6}});
    }
}

TEST(TextureIslands, AnOpaqueImageWithHolesShowsWhatIsInThem) {
  Plant plant;
  plant.materials = {{.name = "leaf", .image = 0}};
  plant.images = {paint([](std::uint32_t x, std::uint32_t y) -> Rgba {
    if ((x / 11 + y / 9) % 2 == 0) return striped(x, y, kGreen);
    return {200, 30, 30, 0};
  })};
  add_leaf(plant, 0, {0.0f, 0.0f}, {256.0f, 256.0f});
  expect_means_kept(plant, {{"leaves", false, 0, 2}});
}

TEST(TextureIslands, BarkThatRepeatsKeepsItsColourBesideLeaves) {
  Plant plant;
  plant.materials = {{.name = "all", .image = 0, .alpha_cutoff = 0.5f}};
  plant.images = {paint([](std::uint32_t x, std::uint32_t y) -> Rgba {
    if (x < 128) return striped(x, y, kBark);
    return x >= 140 && x < 240 && y >= 20 && y < 200 ? striped(x, y, kGreen) : Rgba{255, 255, 255, 0};
  })};
  add_rectangle(plant.wood, 0, {0.0f, 0.0f}, {128.0f, 256.0f * 6.5f});
  add_leaf(plant, 0, {130.0f, 10.0f}, {250.0f, 210.0f});
  add_leaf(plant, 0, {130.0f, 10.0f}, {250.0f, 210.0f}, 0.5f);
  expect_means_kept(plant, {{"leaves", false, 0, 4}, {"bark", true, 0, 2}});
}

TEST(ShownTexels, WeighBySurface) {
  // Two halves of a leaf: the lower one is drawn on nine times the surface; a third of the columns is not shown.
  Plant plant;
  plant.materials = {{.name = "leaf", .image = 0}};
  plant.images = {paint([](std::uint32_t, std::uint32_t y) { return y < 128 ? Rgba{60, 120, 40, 255} : Rgba{50, 100, 40, 255}; })};
  add_leaf(plant, 0, {0.0f, 0.0f}, {160.5f, 128.0f});
  add_leaf(plant, 0, {256.0f, -128.0f}, {416.5f, 0.0f}, 3.0f);  // the same a period on
  measure_shown_texels(plant);
  const std::vector<float>& shown = plant.images[0].shown;
  ASSERT_EQ(shown.size(), std::size_t{kSide} * kSide);
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x) {
      const double half = x < 160 ? 1.0 : x == 160 ? 0.5 : 0.0;
      ASSERT_NEAR(shown[y * kSide + x], half * (y < 128 ? 1.0 / 9.0 : 1.0), 1e-3) << x << " " << y;
    }
  EXPECT_EQ(shown[200], 0.0f);
  const Image last = mip_levels(plant.images[0], 0.0f).back();
  EXPECT_NEAR(last.rgba[1], 102, 1);
}

TEST(ShownTexels, APointALineAndABarkOfManyPeriodsAreShown) {
  ShownArea area({8, 4});
  area.add({glm::vec2(0.3f, 0.3f), glm::vec2(0.3f, 0.3f), glm::vec2(0.3f, 0.3f)}, 0.5);
  const std::vector<float> point = area.weights();
  EXPECT_EQ(point[1 * 8 + 2], 1.0f);
  EXPECT_EQ(std::ranges::count(point, 0.0f), 31);
  area.add({glm::vec2(0.0f, 0.9f), glm::vec2(1.0f, 0.9f), glm::vec2(0.5f, 0.9f)}, 0.5);
  EXPECT_EQ(std::ranges::count(area.weights(), 0.0f), 23);
  for (const float periods : {10.0f, 1000.0f}) {
    ShownArea bark({8, 4});
    bark.add({glm::vec2(0.0f, 0.0f), glm::vec2(periods, 0.0f), glm::vec2(0.0f, periods)}, 1.0);
    for (const float weight : bark.weights()) EXPECT_NEAR(weight, 1.0f, 0.2f) << periods;
  }
}

}  // namespace coppice::bake::texture_islands_test
