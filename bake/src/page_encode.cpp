#include "page_encode.h"

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>

#include "check.h"
#include "page_layout.h"

namespace coppice::bake {

namespace {

page_layout::SplitValues values_of(const Split& split, std::uint32_t split_index, const QuantisedQuad& parent) {
  COPPICE_ASSERT(split.parent <= 2 * split_index);
  page_layout::SplitValues values{};
  values[0] = 2 * split_index - split.parent;
  const page_layout::SlotRank rank = page_layout::rank_of_slots(split.parent_slots);
  values[1] = rank.set;
  values[2] = rank.order;
  values[3] = split.cards[0];
  values[4] = split.cards[1];
  page_layout::Slots slots = page_layout::parent_corners(parent, split.parent_slots);
  std::size_t next = 0;
  for (std::size_t slot = 0; slot < 8; ++slot) {
    if (slots.known[slot]) continue;
    const QuantisedPoint guess = page_layout::predict_corner(slots, slot);
    const QuantisedPoint& vertex = split.new_vertices[next];
    for (std::size_t axis = 0; axis < 3; ++axis) values[5 + 3 * next + axis] = page_layout::zigzag(vertex[axis] - guess[axis]);
    slots.set(slot, vertex);
    ++next;
  }
  return values;
}

void add_attribute(draco::PointCloud& points, const std::vector<page_layout::SplitValues>& values, std::size_t column,
                   std::uint8_t components) {
  draco::GeometryAttribute description;
  description.Init(draco::GeometryAttribute::GENERIC, nullptr, components, draco::DT_INT32, false,
                   std::int64_t{components} * static_cast<std::int64_t>(sizeof(std::int32_t)), 0);
  const int id = points.AddAttribute(description, true, static_cast<std::uint32_t>(values.size()));
  for (std::uint32_t point = 0; point < values.size(); ++point) {
    std::array<std::int32_t, 3> stored{};
    for (std::size_t c = 0; c < components; ++c) stored[c] = page_layout::unzigzag(values[point][column + c]);
    points.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(point), stored.data());
  }
}

}  // namespace

Result<std::vector<std::uint8_t>> encode_page(std::span<const Split> splits, std::uint32_t first_split,
                                              std::span<const QuantisedQuad> quads) {
  COPPICE_ASSERT(!splits.empty() && quads.size() >= 2 * (first_split + splits.size()) + 1);
  std::vector<page_layout::SplitValues> values;
  for (std::uint32_t i = 0; i < splits.size(); ++i) values.push_back(values_of(splits[i], first_split + i, quads[splits[i].parent]));

  draco::PointCloud points;
  points.set_num_points(static_cast<std::uint32_t>(values.size()));
  std::size_t column = 0;
  for (std::uint8_t components : page_layout::kAttributeComponents) {
    add_attribute(points, values, column, components);
    column += components;
  }
  draco::ExpertEncoder encoder(points);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(0, 0);
  for (int id = 0; id < points.num_attributes(); ++id)
    if (!encoder.SetAttributePredictionScheme(id, draco::PREDICTION_NONE).ok()) return Error{Status::internal, "page encoder: prediction"};
  draco::EncoderBuffer buffer;
  if (const draco::Status status = encoder.EncodeToBuffer(&buffer); !status.ok())
    return Error{Status::internal, "page encoder", Error::kNoOffset, status.error_msg_string()};
  if (buffer.size() > COPPICE_MAX_PAGE_BYTES) return Error{Status::invalid_argument, "page encoder: page too long"};
  return std::vector<std::uint8_t>(buffer.data(), buffer.data() + buffer.size());
}

}  // namespace coppice::bake
