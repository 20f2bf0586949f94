#pragma once

// The first bytes of a Draco stream, as this project writes them and as it demands them before it lets Draco allocate.

#include <array>
#include <cstdint>
#include <vector>

namespace coppice::draco_header {

enum class Geometry { sequential_points, edgebreaker_mesh };

/// "DRACO", version, kind, method, flags: 11 bytes.
inline std::vector<std::uint8_t> prefix(Geometry geometry) {
  const bool mesh = geometry == Geometry::edgebreaker_mesh;
  const auto byte = [mesh](int for_mesh, int for_points) { return static_cast<std::uint8_t>(mesh ? for_mesh : for_points); };
  return {'D', 'R', 'A', 'C', 'O', 2, byte(2, 3), byte(1, 0), byte(1, 0), 0, 0};
}

struct Attribute {
  int type;       ///< draco::GeometryAttribute::Type
  int data_type;  ///< draco::DataType
  int components;
  int unique_id;  ///< < 128: one byte as a varint
};

/// An attribute's descriptor; not normalised.
inline std::array<std::uint8_t, 5> attribute(const Attribute& description) {
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  return {byte(description.type), byte(description.data_type), byte(description.components), 0, byte(description.unique_id)};
}

/// draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER and its like.
inline constexpr std::uint8_t kIntegerDecoder = 1, kQuantizationDecoder = 2, kNormalsDecoder = 3;

}  // namespace coppice::draco_header
