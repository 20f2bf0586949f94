#include "card_looks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "srgb.h"

namespace coppice::gpu {
namespace {

constexpr std::uint32_t kWoodColorSide = 32;
constexpr std::uint32_t kWoodColors = (4 * kWoodColorSide * kWoodColorSide - 1) / 3;

/// Sums over sampled texels that are no holes.
struct Sums {
  std::array<double, 3> color{};
  std::uint32_t count = 0;

  void add(const Texel& texel) {
    for (std::size_t channel = 0; channel < 3; ++channel) color[channel] += static_cast<double>(texel[channel]);
    ++count;
  }
  void add(const Sums& other) {
    for (std::size_t channel = 0; channel < 3; ++channel) color[channel] += other.color[channel];
    count += other.count;
  }
  [[nodiscard]] vec3 times(const vec3& base_color) const {
    if (count == 0) return base_color;
    const auto mean = [&](std::size_t channel) { return static_cast<float>(color[channel] / count); };
    return vec3(mean(0), mean(1), mean(2)) * base_color;
  }
};

vec3 color_of(const coppice_file_material& material) {
  return {material.base_color[0], material.base_color[1], material.base_color[2]};
}

/// The range of texels in [part / parts, (part + 1) / parts) of a side: at least one.
std::array<std::uint32_t, 2> texels_of(std::uint32_t part, std::uint32_t parts, std::uint32_t side_px) {
  const std::uint32_t first = part * side_px / parts;
  return {first, std::max(first + 1, (part + 1) * side_px / parts)};
}

Sums part_of(const Texels& texels, float alpha_cutoff, std::array<std::uint32_t, 2> columns, std::array<std::uint32_t, 2> rows) {
  Sums sums;
  for (std::uint32_t y = rows[0]; y < rows[1]; ++y)
    for (std::uint32_t x = columns[0]; x < columns[1]; ++x) {
      const std::uint8_t* texel = texels.rgba.data() + 4 * (std::size_t{y} * texels.width + x);
      if (static_cast<float>(texel[3]) >= 255.0f * alpha_cutoff)
        sums.add(Texel{linear_from_srgb8(texel[0]), linear_from_srgb8(texel[1]), linear_from_srgb8(texel[2]), 1.0f});
    }
  return sums;
}

/// parts, colors: [kWoodColors], parts is scratch. A part that consists of holes gets the colour of its surroundings.
void look_at_material(const coppice_file_material& material, const Texels& texels, std::span<Sums> parts, std::span<std::uint32_t> colors) {
  std::ranges::fill(parts, Sums{});
  for (std::uint32_t y = 0; y < kWoodColorSide; ++y)
    for (std::uint32_t x = 0; x < kWoodColorSide; ++x)
      parts[y * kWoodColorSide + x] =
          part_of(texels, material.alpha_cutoff, texels_of(x, kWoodColorSide, texels.width), texels_of(y, kWoodColorSide, texels.height));
  const auto parent = [&](std::uint32_t first, std::uint32_t side, std::uint32_t x, std::uint32_t y) -> Sums& {
    return parts[first + side * side + y / 2 * (side / 2) + x / 2];
  };
  for (std::uint32_t side = kWoodColorSide, first = 0; side > 1; first += side * side, side /= 2)
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x) parent(first, side, x, y).add(parts[first + y * side + x]);
  std::uint32_t first = kWoodColors - 1;
  for (std::uint32_t side = 2; side <= kWoodColorSide; side *= 2) {
    first -= side * side;
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x)
        if (Sums& part = parts[first + y * side + x]; part.count == 0) part = parent(first, side, x, y);
  }
  std::ranges::transform(parts, colors.begin(), [&](const Sums& part) { return pack_albedo(part.times(color_of(material))); });
}

std::uint32_t wood_color_count(const coppice_file_material& material) {
  return material_texture(material) == COPPICE_NO_TEXTURE ? 1 : kWoodColors;
}

Result<void> allocate_looks(const PlantFile& file, const coppice_allocator& allocator, PlantLooks& plant) {
  COPPICE_CHECK(move_into(plant.materials, enlarged_copy(file.materials, allocator, file.materials.size())));
  COPPICE_CHECK(allocate_into(plant.looks, allocator, file.cards.size() + file.materials.size()));
  COPPICE_CHECK(allocate_into(plant.small, allocator, file.small_textures.size()));
  COPPICE_CHECK(allocate_into(plant.first_wood_color, allocator, file.materials.size()));
  std::uint32_t color_count = 0;
  for (std::size_t i = 0; i < file.materials.size(); ++i)
    plant.first_wood_color[i] = std::exchange(color_count, color_count + wood_color_count(file.materials[i]));
  return allocate_into(plant.wood_colors, allocator, color_count);
}

}  // namespace

bool is_masked(const coppice_file_material& material) {
  return material.alpha_cutoff > 0.0f && material_texture(material) != COPPICE_NO_TEXTURE;
}

TriangleLook triangle_look(const PlantLooks& plant, std::uint32_t index, const TriangleUvs& uvs, std::uint32_t side) {
  const coppice_file_material& material = plant.materials[index];
  TriangleLook look{.albedo = color_of(material)};
  const std::uint32_t texture = material_texture(material);
  if (texture >= plant.small.size()) return look;
  Sums sums;
  // b, c: weights of the second and third corner
  const auto look_at = [&](float b, float c) {
    const auto at = [&](std::size_t axis) { return (1.0f - b - c) * uvs[0][axis] + b * uvs[1][axis] + c * uvs[2][axis]; };
    const Texel texel = texel_at(plant.small[texture], at(0), at(1));
    if (texel[3] >= material.alpha_cutoff) sums.add(texel);
  };
  const float part = 1.0f / static_cast<float>(side);
  for (std::uint32_t row = 0; row < side; ++row)
    for (std::uint32_t column = 0; column + row < side; ++column) {
      const float b = part * static_cast<float>(column), c = part * static_cast<float>(row);
      look_at(b + part / 3.0f, c + part / 3.0f);
      if (column + row + 1 < side) look_at(b + part / 1.5f, c + part / 1.5f);  // the part that is upside down
    }
  look.albedo = sums.times(color_of(material));
  look.coverage = static_cast<float>(sums.count) / static_cast<float>(side * side);
  return look;
}

std::uint32_t wood_color_of(const PlantLooks& plant, std::uint32_t material, const TriangleUvs& uvs) {
  std::uint32_t first = plant.first_wood_color[material];
  if (material_texture(plant.materials[material]) == COPPICE_NO_TEXTURE) return plant.wood_colors[first];
  const auto edge = [&](std::size_t corner, std::size_t axis) { return uvs[corner][axis] - uvs[0][axis]; };
  const float area = 0.5f * std::abs(edge(1, 0) * edge(2, 1) - edge(1, 1) * edge(2, 0));
  std::uint32_t side = kWoodColorSide;
  for (; side > 1 && !(area * static_cast<float>(side * side) < 2.0f); side /= 2) first += side * side;
  const auto part = [&](std::size_t axis) {
    const float middle = (uvs[0][axis] + uvs[1][axis] + uvs[2][axis]) / 3.0f, within = middle - std::floor(middle);
    return within >= 0.0f ? std::min(static_cast<std::uint32_t>(within * static_cast<float>(side)), side - 1) : 0;
  };
  return plant.wood_colors[first + part(1) * side + part(0)];
}

std::size_t PlantLooks::bytes() const {
  std::size_t sum = materials.bytes() + looks.bytes() + small.bytes() + wood_colors.bytes() + first_wood_color.bytes();
  for (const Texels& texels : small) sum += texels.rgba.bytes();
  return sum;
}

Result<PlantLooks> plant_looks(const PlantFile& file, const coppice_allocator& allocator) {
  PlantLooks plant;
  COPPICE_CHECK(allocate_looks(file, allocator, plant));
  COPPICE_TRY(parts, HookArray<Sums>::allocate(allocator, kWoodColors));
  CardLook* look = plant.looks.data();
  for (const coppice_file_card& card : file.cards) {
    const int covered = std::popcount(card.mask[0]) + std::popcount(card.mask[1]);
    *look++ = {.albedo = {linear_from_srgb8(card.albedo[0]), linear_from_srgb8(card.albedo[1]), linear_from_srgb8(card.albedo[2])},
               .coverage = static_cast<float>(covered) / 64.0f,
               .mask = {card.mask[0], card.mask[1]},
               .roughness = file.materials[card.material].roughness};
  }
  for (std::size_t i = 0; i < file.small_textures.size(); ++i) {
    const HookBuffer& chunk = file.small_textures[i];
    const auto layout = read_texture(chunk);
    if (!layout) continue;
    COPPICE_CHECK(move_into(plant.small[i], level_of(*layout, chunk, COPPICE_MAX_SMALL_TEXTURE_SIDE, allocator)));
  }
  for (std::size_t i = 0; i < file.materials.size(); ++i) {
    const coppice_file_material& material = file.materials[i];
    *look++ = {.albedo = color_of(material), .coverage = 1.0f, .mask = {0xffffffffu, 0xffffffffu}, .roughness = material.roughness};
    const std::span<std::uint32_t> colors = plant.wood_colors.span().subspan(plant.first_wood_color[i], wood_color_count(material));
    if (colors.size() == 1)
      colors[0] = pack_albedo(color_of(material));
    else
      look_at_material(material, plant.small[material_texture(material)], parts.span(), colors);
  }
  if (file.plant.leaf_mesh_count == 0 && std::ranges::none_of(file.materials, is_masked)) plant.small.reset();
  return plant;
}

}  // namespace coppice::gpu
