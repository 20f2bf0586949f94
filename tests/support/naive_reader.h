#pragma once

// A second reader of .coppice files, written from FORMAT.md alone: no code or layout of the product's is used. It reads a whole file, as
// plainly as it can, and is slow. What it and the product's reader disagree about is wrong in one of them, or in FORMAT.md.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace coppice::test {

/// Why a file is refused. Thrown inside; read_naively() does not let it out.
struct NaiveRefusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct NaiveChunk {
  std::uint32_t kind = 0, index = 0;
  std::uint64_t offset = 0, bytes = 0;
};

struct NaiveMaterial {
  std::array<float, 4> base_color{};
  float alpha_cutoff = 0, roughness = 0;
  std::uint32_t texture = 0, normal_map = 0;  ///< as stored
  std::uint32_t flags = 0;
};

struct NaiveCard {
  std::uint32_t material = 0;
  std::array<float, 8> uv{};
  std::array<std::uint32_t, 3> albedo{};
  std::array<std::uint32_t, 2> mask{};
};

using NaivePoint = std::array<std::int64_t, 3>;
using NaiveQuad = std::array<NaivePoint, 4>;

inline constexpr std::uint32_t kNaiveNone = 0xffffffffu;

struct NaiveNode {
  NaiveQuad corners{};
  std::uint32_t card = 0;
  std::uint32_t opacity = 16;  ///< sixteenths
  /// 0 either side, 1 the front is along the axis, 2 against it, 3 the quad's own normal; all others are then 0
  std::uint32_t side = 3;
  std::uint32_t along = 0;              ///< fifteenths
  std::array<std::uint32_t, 2> axis{};  ///< u and v, 0..31
  std::uint32_t death = kNaiveNone;     ///< the split that replaces it
};

/// How many bits of u and v are free.
inline std::uint32_t naive_axis_bits(std::uint32_t along) {
  if (along >= 1 && along <= 9) return 3;
  return along <= 12 ? 4 : 5;
}
/// u or v whose highest `bits` are the number `high`.
inline std::uint32_t naive_axis_step(std::uint32_t high, std::uint32_t bits) {
  constexpr std::array<std::uint32_t, 8> kOfThree = {0, 4, 9, 13, 18, 22, 27, 31};
  if (bits == 3) return kOfThree[high];
  return bits == 4 ? 2 * high + high / 8 : high;
}

struct NaiveSplit {
  std::uint32_t parent = 0;
  std::array<std::uint32_t, 4> parent_slots{};
};

struct NaiveVertex {
  std::array<float, 3> position{}, normal{};
  std::array<float, 2> uv{};
  std::uint32_t material = 0;
  std::array<std::uint32_t, 3> stalk{};
};

/// A WOOD or a LEAF_MESH: three corners a triangle, each with its vertex.
struct NaiveMesh {
  std::uint32_t vertex_count = 0;
  std::vector<NaiveVertex> corners;
};

struct NaiveTexture {
  std::uint32_t width = 0, height = 0, mip_count = 0, format = 0;
  std::vector<std::uint8_t> levels;
};

struct NaiveWindNode {
  double lean = 0, sway_cos = 0, sway_sin = 0;
};

struct NaiveWind {
  float base_y_m = 0, height_m = 0, bend_m = 0, lean_m = 0, sway_m = 0, stem_period_s = 0, branch_period_s = 0;
  std::array<float, 3> box_min{}, box_max{};
  std::uint32_t side = 0;
  std::vector<NaiveWindNode> nodes;
};

struct NaivePlant {
  std::uint64_t first_read_bytes = 0;
  std::vector<NaiveChunk> chunks;
  std::uint32_t leaf_count = 0, page_count = 0, texture_count = 0, wood_lod_count = 0, metric = 0, leaf_mesh_count = 0;
  std::uint32_t largest = 16383;  ///< the largest quantised coordinate
  std::array<float, 3> leaf_box_min{}, leaf_box_max{}, sphere_center{};
  float sphere_radius = 0;
  std::array<std::uint32_t, 8> wood_vertex_counts{}, wood_triangle_counts{};
  std::string name;
  std::vector<NaiveMaterial> materials;
  std::vector<NaiveCard> cards;
  std::vector<std::uint32_t> error_leaf_counts;
  std::vector<float> error_sizes_px, error_px, wood_error_px, leaf_mesh_error_px;
  NaiveWind wind_field;
  std::vector<std::uint32_t> leaf_mesh_vertex_counts, leaf_mesh_triangle_counts;
  std::vector<NaiveNode> nodes;  ///< [2N - 1]
  std::vector<NaiveSplit> splits;
  std::vector<NaiveMesh> wood, leaf_meshes;
  std::vector<NaiveTexture> textures, small_textures;  ///< the latter empty of those that are no base colour
};

/// A refusal, empty for a file that is right; what is in `plant` is then all of it.
struct NaiveReading {
  std::string refusal;
  NaivePlant plant;
};

NaiveReading read_naively(std::span<const std::uint8_t> file);

// The parts, for naive_reader.cpp.

inline void naive_must(bool holds, const char* what) {
  if (!holds) throw NaiveRefusal(what);
}

/// Little-endian values, one after another; refuses to read past the end.
class NaiveBytes {
 public:
  explicit NaiveBytes(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::uint64_t number(std::size_t byte_count);
  std::uint32_t u8() { return static_cast<std::uint32_t>(number(1)); }
  std::uint32_t u16() { return static_cast<std::uint32_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t u64() { return number(8); }
  std::int64_t i16();
  float f32();
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  std::span<const std::uint8_t> rest() { return take(left()); }
  std::span<const std::uint8_t> take(std::size_t byte_count);

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Section 9: the next page's splits; appends to the plant's nodes and splits. `parents` [N - 1]: the node that each split replaces, as far
/// as earlier pages have said.
void read_naive_page(std::span<const std::uint8_t> bytes, NaivePlant& plant, std::vector<std::uint32_t>& parents);
/// Sections 10 and 12.
NaiveMesh read_naive_mesh(std::span<const std::uint8_t> bytes, std::uint32_t vertex_count, std::uint32_t triangle_count, bool has_stalks,
                          std::size_t material_count);

}  // namespace coppice::test
