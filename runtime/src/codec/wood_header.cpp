#include "wood_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include <draco/attributes/geometry_attribute.h>

#include "coppice/format.h"
#include "draco_header.h"

namespace coppice {

namespace {

constexpr std::uint32_t kMaxAttributes = 5;

/// Reads forward; after the end it stays failed and returns zeros.
class Cursor {
 public:
  explicit Cursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] bool failed() const { return failed_; }
  [[nodiscard]] std::size_t at() const { return at_; }

  std::uint8_t byte() {
    if (failed_ || at_ == bytes_.size()) return fail();
    return bytes_[at_++];
  }

  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t next = byte();
      value |= static_cast<std::uint64_t>(next & 0x7f) << shift;
      if ((next & 0x80) == 0) return value;
    }
    return fail();
  }

  void skip(std::uint64_t count) {
    if (failed_ || count > bytes_.size() - at_)
      fail();
    else
      at_ += static_cast<std::size_t>(count);
  }

 private:
  std::uint8_t fail() {
    failed_ = true;
    return 0;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

Error bad_at(const Cursor& cursor, const char* what, const std::string& detail = {}) {
  return {Status::bad_file, what, Error::kNoOffset,
          "byte " + std::to_string(cursor.at()) + " of the chunk" + (detail.empty() ? "" : ", ") + detail};
}

/// Checks Draco's prefix, the traversal kind and the counts; leaves the cursor behind them.
Result<void> check_counts(Cursor& cursor, std::uint64_t byte_count, const WoodShape& shape, std::uint32_t& attribute_data_count) {
  for (std::uint8_t expected : draco_header::kPrefix)
    if (cursor.byte() != expected || cursor.failed()) return bad_at(cursor, "wood Draco header");
  if (cursor.byte() != 0) return bad_at(cursor, "wood traversal");  // standard traversal: every triangle takes at least a bit
  const std::uint64_t vertices = cursor.varint(), triangles = cursor.varint();
  attribute_data_count = cursor.byte();
  const std::uint64_t symbols = cursor.varint(), split_symbols = cursor.varint();
  if (cursor.failed()) return bad_at(cursor, "wood Draco header", "cut off");
  if (triangles != shape.triangle_count || triangles > COPPICE_MAX_WOOD_TRIANGLES_PER_BYTE * byte_count)
    return bad_at(cursor, "wood triangle count", std::to_string(triangles));
  if (vertices > shape.vertex_count || symbols > triangles || split_symbols > symbols)
    return bad_at(cursor, "wood vertex count", std::to_string(vertices));
  if (attribute_data_count > kMaxAttributes) return bad_at(cursor, "wood attribute count", std::to_string(attribute_data_count));
  return {};
}

/// Skips split events, symbols, start faces and attribute seams; each states its length.
Result<void> skip_connectivity(Cursor& cursor, std::uint32_t attribute_data_count, std::uint32_t triangle_count) {
  const std::uint64_t split_events = cursor.varint();
  if (split_events > triangle_count) return bad_at(cursor, "wood split events", std::to_string(split_events));
  for (std::uint64_t i = 0; i < 2 * split_events && !cursor.failed(); ++i) cursor.varint();
  cursor.skip((split_events + 7) / 8);
  cursor.skip(cursor.varint());
  for (std::uint32_t coder = 0; coder < 1 + attribute_data_count; ++coder) {
    cursor.byte();
    cursor.skip(cursor.varint());
  }
  if (cursor.failed()) return bad_at(cursor, "wood connectivity", "cut off");
  return {};
}

/// Index of an attribute descriptor in FORMAT.md's list; the last one, the stalk, is only for leaf meshes.
std::optional<std::size_t> known_attribute(const std::array<std::uint8_t, 5>& descriptor, bool has_stalks, std::uint8_t& decoder) {
  struct Known {
    int type, data_type, components;
    std::uint8_t decoder;
  };
  static constexpr std::array<Known, kMaxAttributes> kKnown = {{
      {draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, draco_header::kQuantizationDecoder},
      {draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, 3, draco_header::kNormalsDecoder},
      {draco::GeometryAttribute::TEX_COORD, draco::DT_FLOAT32, 2, draco_header::kQuantizationDecoder},
      {draco::GeometryAttribute::GENERIC, draco::DT_UINT8, 1, draco_header::kIntegerDecoder},
      {draco::GeometryAttribute::GENERIC, draco::DT_UINT16, 3, draco_header::kIntegerDecoder},
  }};
  for (std::size_t i = 0; i < kKnown.size() - (has_stalks ? 0 : 1); ++i) {
    const auto expected = draco_header::attribute({kKnown[i].type, kKnown[i].data_type, kKnown[i].components, descriptor[4]});
    if (descriptor != expected) continue;
    decoder = kKnown[i].decoder;
    return i;
  }
  return std::nullopt;
}

/// Checks the attributes of one decoder; each must be known and new.
Result<void> check_attributes(Cursor& cursor, bool has_stalks, std::array<bool, kMaxAttributes>& seen) {
  const std::uint64_t count = cursor.varint();
  if (count == 0 || count > seen.size()) return bad_at(cursor, "wood attribute count", std::to_string(count));
  std::array<std::uint8_t, kMaxAttributes> decoders{};
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint8_t, 5> descriptor{};
    for (std::uint8_t& byte : descriptor) byte = cursor.byte();
    const auto known = known_attribute(descriptor, has_stalks, decoders[i]);
    if (!known || seen[*known]) return bad_at(cursor, "wood attribute");
    seen[*known] = true;
  }
  for (std::size_t i = 0; i < count; ++i)
    if (cursor.byte() != decoders[i]) return bad_at(cursor, "wood attribute coding");
  return {};
}

}  // namespace

Result<void> check_wood_header(std::span<const std::uint8_t> bytes, const WoodShape& shape) {
  Cursor cursor(bytes);
  std::uint32_t attribute_data_count = 0;
  COPPICE_CHECK(check_counts(cursor, bytes.size(), shape, attribute_data_count));
  COPPICE_CHECK(skip_connectivity(cursor, attribute_data_count, shape.triangle_count));
  const std::uint32_t decoder_count = cursor.byte();
  if (decoder_count == 0 || decoder_count > kMaxAttributes) return bad_at(cursor, "wood attribute count", std::to_string(decoder_count));
  cursor.skip(3 * decoder_count);  // each decoder's connectivity, element and traversal
  std::array<bool, kMaxAttributes> seen{};
  seen.back() = !shape.has_stalks;
  for (std::uint32_t decoder = 0; decoder < decoder_count; ++decoder) COPPICE_CHECK(check_attributes(cursor, shape.has_stalks, seen));
  if (cursor.failed() || !std::ranges::all_of(seen, [](bool found) { return found; }))
    return bad_at(cursor, "wood attribute", "one is missing");
  return {};
}

}  // namespace coppice
