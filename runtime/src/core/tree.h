#pragma once

// The collapse tree in refinement order, as the file stores it and as the layers above the codec see it.
//
// Split s replaces node parent(s) by nodes 2s+1 and 2s+2; node 0 is the root. cut(m) is the set of nodes alive after the first m-1 splits:
// the nodes with id < 2m-1 that none of those splits replaced. Any prefix of the splits is a complete plant.
//
// A parent's four vertices are four of its children's eight, so a split carries only four new vertices and says which of the eight child
// slots the parent's vertices fill. Slots 0..3 are the corners of child 2s+1, slots 4..7 those of child 2s+2.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace coppice {

/// A quantised position: three integers in [0, COPPICE_QUANTISED_MAX] in the plant's leaf box.
using QuantisedPoint = std::array<std::uint16_t, 3>;
/// A leaf quad's corners in ring order. Corner 0 and 3 are at the stalk end of a source leaf, 1 and 2 at its tip;
/// the two triangles are (0, 1, 2) and (0, 2, 3).
using QuantisedQuad = std::array<QuantisedPoint, 4>;

/// PageNode::split of a node that is never replaced.
inline constexpr std::uint32_t kNeverReplaced = 0xffffffffu;

/// PageNode::by_death after the last node that is replaced.
inline constexpr std::uint16_t kNoPlace = 0xffff;

/// Opacities are in sixteenths, 1 to 16. A node that stands for several leaves is as transparent as the gaps between them.
inline constexpr std::uint8_t kOpaque = 16;
/// Transparency in sixteenths, 0 to 15: the share of the gaps.
[[nodiscard]] constexpr std::uint32_t transparency_of(std::uint8_t opacity) {
  return static_cast<std::uint32_t>(kOpaque - opacity);
}

// A node's *normals* say how the normals n of the leaves that it stands for lie: the second moment M = mean of n n^T by area, which decides
// what light does to them (coppice_surface.glsl). M is taken to be rotationally symmetric about an axis a: M = l a a^T + (1 - l) / 2 (I - a
// a^T), where l, 0 to 1, is how far normals lie along the axis: 1 for one flat leaf, 1/3 for leaves of all directions, 0 for leaves about a
// twig. They have 16 bits:
//   bits 0..4, 5..9   axis: u and v of the octahedron's upper half (axis_share). As many high bits count as axis_bits says; those below
//                     repeat them
//   bits 10..13       along: 15 l
//   bits 14, 15       side: NormalSide

enum class NormalSide : std::uint8_t {
  either = 0,    ///< the side that the eye sees counts as the front
  along = 1,     ///< the front is where the axis points, whoever looks: normals that an artist gave
  against = 2,   ///< the front is where the axis points away from
  own_quad = 3,  ///< one flat leaf: the axis is the quad's own normal, l is 1, either side; all other bits are 0
};
inline constexpr std::uint32_t kAxisBits = 5, kAxisSteps = 31, kAlongSteps = 15;
inline constexpr std::uint16_t kFlatNormals = 0xc000;

[[nodiscard]] constexpr NormalSide side_of(std::uint16_t normals) {
  return static_cast<NormalSide>(normals >> 14);
}
[[nodiscard]] constexpr std::uint32_t along_step_of(std::uint16_t normals) {
  return std::uint32_t{normals} >> 10 & kAlongSteps;
}
/// u (0) or v (1) of the axis, 0..kAxisSteps.
[[nodiscard]] constexpr std::uint32_t axis_step_of(std::uint16_t normals, std::size_t which) {
  return std::uint32_t{normals} >> (5 * which) & kAxisSteps;
}
[[nodiscard]] constexpr std::uint16_t pack_normals(std::uint32_t u, std::uint32_t v, std::uint32_t along, NormalSide side) {
  return static_cast<std::uint16_t>(u | v << 5 | along << 10 | static_cast<std::uint32_t>(side) << 14);
}

/// How many high bits of u and v count, 3 to kAxisBits: an axis matters by how far l is from 1/3, where normals have all directions alike.
[[nodiscard]] constexpr std::uint32_t axis_bits(std::uint32_t along_step) {
  constexpr std::uint32_t kEvenStep = kAlongSteps / 3;
  const std::uint32_t off = along_step > kEvenStep ? along_step - kEvenStep : kEvenStep - along_step;
  return off <= 4 ? 3 : off <= 7 ? 4 : kAxisBits;
}
/// u or v, -1..1, of its high bits: half of their number is 0, so that straight up is exact; 0 and 1 are -1.
[[nodiscard]] constexpr float axis_share(std::uint32_t high, std::uint32_t bits) {
  const std::int32_t half = 1 << (bits - 1), steps = static_cast<std::int32_t>(high) - half;
  return static_cast<float>(steps > -half ? steps : 1 - half) / static_cast<float>(half - 1);
}
/// All bits of u or v from its high ones.
[[nodiscard]] constexpr std::uint32_t axis_step_from(std::uint32_t high, std::uint32_t bits) {
  return high << (kAxisBits - bits) | high >> (2 * bits - kAxisBits);
}

/// Whether the bits are normals that the file may hold.
[[nodiscard]] constexpr bool are_normals(std::uint16_t normals) {
  if (side_of(normals) == NormalSide::own_quad) return normals == kFlatNormals;
  const std::uint32_t bits = axis_bits(along_step_of(normals));
  const auto holds = [&](std::uint32_t step) { return step == axis_step_from(step >> (kAxisBits - bits), bits); };
  return holds(axis_step_of(normals, 0)) && holds(axis_step_of(normals, 1));
}

/// Normals as shading takes them.
struct ShadingNormals {
  std::array<float, 3> axis{};  ///< unit, on the front if there is one
  float along = 1.0f;           ///< l
  bool is_sided = false;        ///< whether the axis says which side is the front
};
/// quad_normal  the quad's own, unit
[[nodiscard]] inline ShadingNormals unpack_normals(std::uint16_t normals, const std::array<float, 3>& quad_normal) {
  const NormalSide side = side_of(normals);
  if (side == NormalSide::own_quad) return {quad_normal, 1.0f, false};
  const std::uint32_t bits = axis_bits(along_step_of(normals));
  const auto share = [&](std::size_t which) { return axis_share(axis_step_of(normals, which) >> (kAxisBits - bits), bits); };
  // u = x + z, v = x - z, where |x| + y + |z| = 1.
  const float u = share(0), v = share(1), x = 0.5f * (u + v), z = 0.5f * (u - v), y = 1.0f - std::abs(x) - std::abs(z);
  const float scale = (side == NormalSide::against ? -1.0f : 1.0f) / std::sqrt(x * x + y * y + z * z);
  const float along = static_cast<float>(along_step_of(normals)) / static_cast<float>(kAlongSteps);
  return {{x * scale, y * scale, z * scale}, along, side != NormalSide::either};
}

/// A node in the layout that pages are decoded into.
struct PageNode {
  QuantisedQuad corners{};
  std::uint8_t card = 0;           ///< < COPPICE_MAX_CARDS
  std::uint8_t opacity = kOpaque;  ///< 1..kOpaque
  /// An index of the page, not a property of this node: node k has the place in the page of the k-th node to be replaced, kNoPlace after
  /// the last.
  std::uint16_t by_death = 0;
  std::uint32_t split = kNeverReplaced;  ///< the split that replaces this node, in whichever page it is
  std::uint16_t normals = kFlatNormals;
  std::uint16_t reserved = 0;
};
static_assert(sizeof(PageNode) == 36 && offsetof(PageNode, card) == 24 && offsetof(PageNode, opacity) == 25 &&
              offsetof(PageNode, by_death) == 26 && offsetof(PageNode, split) == 28 && offsetof(PageNode, normals) == 32);

/// A split as decoded from a page.
struct Split {
  std::uint32_t parent = 0;                      ///< node id, < 2s+1
  std::array<std::uint8_t, 4> parent_slots{};    ///< child slot (0..7) filled by parent corner i; four different slots
  std::array<QuantisedPoint, 4> new_vertices{};  ///< fill the other four slots, ascending
  std::array<std::uint8_t, 2> cards{};           ///< card of each child
};

struct ChildQuads {
  QuantisedQuad first, second;
};

/// Returns the two quads that replace `parent`. `split.parent_slots` must be four different slots (the codec checks it).
[[nodiscard]] inline ChildQuads child_quads(const QuantisedQuad& parent, const Split& split) {
  std::array<QuantisedPoint, 8> slots{};
  std::array<bool, 8> filled{};
  for (std::size_t corner = 0; corner < 4; ++corner) {
    slots[split.parent_slots[corner]] = parent[corner];
    filled[split.parent_slots[corner]] = true;
  }
  std::size_t next = 0;
  for (std::size_t slot = 0; slot < 8 && next < 4; ++slot)
    if (!filled[slot]) slots[slot] = split.new_vertices[next++];
  return {{slots[0], slots[1], slots[2], slots[3]}, {slots[4], slots[5], slots[6], slots[7]}};
}

}  // namespace coppice
