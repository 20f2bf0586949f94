#pragma once

// The collapse tree in refinement order, as the file stores it and as the layers above the codec see it.
//
// Split s replaces node parent(s) by nodes 2s+1 and 2s+2; node 0 is the root. cut(m) is the set of nodes alive after the first m-1 splits:
// the nodes with id < 2m-1 that none of those splits replaced. Any prefix of the splits is a complete plant.
//
// A parent's four vertices are four of its children's eight, so a split carries only four new vertices and says which of the eight child
// slots the parent's vertices fill. Slots 0..3 are the corners of child 2s+1, slots 4..7 those of child 2s+2.

#include <array>
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

/// Brightnesses are steps of a sixteenth, 0 to 15, of a display's value: step b shows (8 + b) / 16 of the leaf's own.
inline constexpr std::uint8_t kUnchangedBrightness = 8;
inline constexpr std::uint8_t kBrightest = 15;
[[nodiscard]] constexpr float displayed_brightness(std::uint8_t step) {
  return static_cast<float>(step + 8u) / 16.0f;
}

/// A node's *fade* packs its opacity and brightness into one byte: the low four bits are the opacity minus one, the high four the
/// brightness. Source leaves, which nothing replaces, have none.
[[nodiscard]] constexpr std::uint8_t fade_of(std::uint8_t opacity, std::uint8_t brightness = kUnchangedBrightness) {
  return static_cast<std::uint8_t>((static_cast<unsigned>(brightness) << 4) | (opacity - 1u));
}
[[nodiscard]] constexpr std::uint8_t opacity_of(std::uint8_t fade) {
  return static_cast<std::uint8_t>((fade & 15u) + 1u);
}
[[nodiscard]] constexpr std::uint8_t brightness_of(std::uint8_t fade) {
  return static_cast<std::uint8_t>(fade >> 4);
}
/// Converts brightness to a factor of linear light. Displays show about its square root.
[[nodiscard]] constexpr float linear_brightness(std::uint8_t fade) {
  const float displayed = displayed_brightness(brightness_of(fade));
  return displayed * displayed;
}
inline constexpr std::uint8_t kNoFade = fade_of(kOpaque);
/// Transparency of a node in sixteenths, 0 to 15: the share of the gaps between the leaves that it stands for.
[[nodiscard]] constexpr std::uint32_t transparency_of(std::uint8_t fade) {
  return static_cast<std::uint32_t>(kOpaque - opacity_of(fade));
}
static_assert(kNoFade == 0x8f && transparency_of(kNoFade) == 0 && displayed_brightness(kUnchangedBrightness) == 1.0f);

/// A node in the layout that pages are decoded into.
struct PageNode {
  QuantisedQuad corners{};
  std::uint8_t card = 0;  ///< < COPPICE_MAX_CARDS
  std::uint8_t fade = kNoFade;
  /// An index of the page, not a property of this node: node k has the place in the page of the k-th node to be replaced, kNoPlace after
  /// the last.
  std::uint16_t by_death = 0;
  std::uint32_t split = kNeverReplaced;  ///< the split that replaces this node, in whichever page it is
};
static_assert(sizeof(PageNode) == 32 && offsetof(PageNode, card) == 24 && offsetof(PageNode, fade) == 25 &&
              offsetof(PageNode, by_death) == 26 && offsetof(PageNode, split) == 28);

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
