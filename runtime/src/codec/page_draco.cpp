// A page of version 1 is a Draco point cloud, sequentially coded so that its points keep their order: one point per split. The header Draco
// would believe (point count, attributes, types) is the same for every page but for the point count, so it is compared byte by byte before
// Draco sees it; what Draco then allocates is bounded by COPPICE_PAGE_SPLITS.

#include "page_draco.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include <draco/compression/decode.h>

#include "draco_header.h"
#include "page_draco_layout.h"
#include "symbol_coder.h"

namespace coppice {

namespace {

using page_draco_layout::SplitValues;

Error bad_page(const char* what, std::size_t point) {
  return {Status::bad_file, what, Error::kNoOffset, "split " + std::to_string(point) + " of the page"};
}

std::vector<std::uint8_t> expected_header(std::uint32_t split_count) {
  std::vector<std::uint8_t> header = draco_header::prefix(draco_header::Geometry::sequential_points);
  for (int shift = 0; shift < 32; shift += 8) header.push_back(static_cast<std::uint8_t>(split_count >> shift));
  header.push_back(1);  // attribute decoders
  header.push_back(static_cast<std::uint8_t>(page_draco_layout::kAttributeComponents.size()));
  for (std::size_t i = 0; i < page_draco_layout::kAttributeComponents.size(); ++i)
    for (std::uint8_t byte : draco_header::attribute({draco::GeometryAttribute::GENERIC, draco::DT_INT32,
                                                      page_draco_layout::kAttributeComponents[i], static_cast<std::uint8_t>(i)}))
      header.push_back(byte);
  header.insert(header.end(), page_draco_layout::kAttributeComponents.size(), draco_header::kIntegerDecoder);
  return header;
}

/// All attributes' values, split by split.
Result<std::vector<SplitValues>> read_values(const draco::PointCloud& points, std::size_t split_count) {
  std::vector<SplitValues> values(split_count);
  std::size_t column = 0;
  for (std::size_t i = 0; i < page_draco_layout::kAttributeComponents.size(); ++i) {
    const std::size_t components = page_draco_layout::kAttributeComponents[i];
    const draco::PointAttribute* attribute = points.attribute(static_cast<int>(i));
    if (attribute == nullptr || attribute->size() != split_count || attribute->num_components() != components ||
        attribute->data_type() != draco::DT_INT32 || attribute->buffer()->data_size() < split_count * components * sizeof(std::int32_t))
      return Error{Status::bad_file, "page attribute", Error::kNoOffset, std::to_string(i)};
    for (std::size_t point = 0; point < split_count; ++point) {
      std::array<std::int32_t, 3> stored{};
      attribute->GetValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(point)), stored.data());
      for (std::size_t c = 0; c < components; ++c) values[point][column + c] = zigzag(stored[c]);
    }
    column += components;
  }
  return values;
}

/// One split from its values; its new vertices need the parent's quad.
Result<Split> split_from_values(const SplitValues& values, std::size_t point, std::uint32_t split_index, std::uint32_t card_count,
                                const NodePages& nodes) {
  Split split;
  if (values[0] > 2 * split_index) return bad_page("page parent", point);
  split.parent = 2 * split_index - values[0];
  if (values[1] >= 70 || values[2] >= 24) return bad_page("page slots", point);
  split.parent_slots = page_draco_layout::slots_of_rank(values[1], values[2]);
  if (values[3] >= card_count || values[4] >= card_count) return bad_page("page card", point);
  split.cards = {static_cast<std::uint8_t>(values[3]), static_cast<std::uint8_t>(values[4])};
  page_draco_layout::Slots slots = page_draco_layout::parent_corners(nodes[split.parent].corners, split.parent_slots);
  std::size_t next = 0;
  for (std::size_t slot = 0; slot < 8; ++slot) {
    if (slots.known[slot]) continue;
    const QuantisedPoint guess = page_draco_layout::predict_corner(slots, slot);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t value = std::int64_t{guess[axis]} + unzigzag(values[5 + 3 * next + axis]);
      if (value < 0 || value > COPPICE_QUANTISED_MAX) return bad_page("page vertex", point);
      split.new_vertices[next][axis] = static_cast<std::uint16_t>(value);
    }
    slots.set(slot, split.new_vertices[next++]);
  }
  return split;
}

/// Writes a split's children and marks its parent. False if the page has replaced that already.
bool apply(const Split& split, std::uint32_t split_index, const PageInfo& info, const PageOutput& out, std::uint32_t& patch_count) {
  const ChildQuads children = child_quads(out.nodes[split.parent].corners, split);
  out.nodes.at(2 * split_index + 1) = {children.first, split.cards[0]};
  out.nodes.at(2 * split_index + 2) = {children.second, split.cards[1]};
  if (split.parent <= 2 * info.page * COPPICE_PAGE_SPLITS) {
    out.patches[patch_count++] = {split.parent, split_index};
    return split.parent != 0 || split_index == 0;
  }
  std::uint32_t& replaced_by = out.nodes.at(split.parent).split;
  if (replaced_by != kNeverReplaced) return false;
  replaced_by = split_index;
  return true;
}

Result<std::uint32_t> decode(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out) {
  const std::vector<std::uint8_t> header = expected_header(info.split_count);
  const auto differs = std::ranges::mismatch(header, bytes).in1 - header.begin();
  if (differs != static_cast<std::ptrdiff_t>(header.size()))
    return Error{Status::bad_file, "page Draco header", Error::kNoOffset, "byte " + std::to_string(differs) + " of the page"};
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  draco::Decoder decoder;
  auto points = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!points.ok()) return Error{Status::bad_file, "page Draco stream", Error::kNoOffset, points.status().error_msg_string()};
  // Draco ignores what follows; past the end it reads zero bits, which check_chunk has ruled out for an undamaged file.
  if (buffer.remaining_size() != 0) return Error{Status::bad_file, "page length"};
  COPPICE_TRY(values, read_values(*points.value(), info.split_count));
  std::uint32_t patch_count = 0;
  for (std::uint32_t i = 0; i < info.split_count; ++i) {
    const std::uint32_t split_index = info.page * COPPICE_PAGE_SPLITS + i;
    COPPICE_TRY(split, split_from_values(values[i], i, split_index, info.card_count, out.nodes));
    if (!apply(split, split_index, info, out, patch_count)) return bad_page("page parent", i);
    if (!out.splits.empty()) out.splits[i] = split;
  }
  return patch_count;
}

}  // namespace

Result<std::uint32_t> decode_draco_page(std::span<const std::uint8_t> bytes, const PageInfo& info, const PageOutput& out) {
  try {
    return decode(bytes, info, out);
  } catch (const std::bad_alloc&) {
    return Error{Status::out_of_memory, "page"};
  } catch (...) {
    return Error{Status::bad_file, "page Draco stream"};
  }
}

}  // namespace coppice
