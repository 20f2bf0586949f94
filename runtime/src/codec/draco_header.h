#pragma once

// The first bytes of a Draco stream. The writer produces them, and the reader demands them before it lets Draco allocate.

#include <array>
#include <cstdint>

namespace coppice::draco_header {

/// "DRACO", version 2.2, a mesh, edgebreaker, no flags.
inline constexpr std::array<std::uint8_t, 11> kPrefix = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0};

struct Attribute {
  int type;       ///< draco::GeometryAttribute::Type
  int data_type;  ///< draco::DataType
  int components;
  int unique_id;  ///< < 128: one byte as a varint
};

/// Bytes of an attribute's descriptor; not normalised.
inline std::array<std::uint8_t, 5> attribute(const Attribute& description) {
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  return {byte(description.type), byte(description.data_type), byte(description.components), 0, byte(description.unique_id)};
}

/// draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER and its like.
inline constexpr std::uint8_t kIntegerDecoder = 1, kQuantizationDecoder = 2, kNormalsDecoder = 3;

}  // namespace coppice::draco_header
