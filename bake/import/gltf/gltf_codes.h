#pragma once

#include <cstdint>

// The numbers by which a glTF 2.0 document says what it holds: `componentType` of accessors and `mode` of primitives; and its largest size.

namespace coppice::bake::gltf_code {

enum ComponentType : std::uint64_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126,
};

enum PrimitiveMode : std::uint64_t { kPoints, kLines, kLineLoop, kLineStrip, kTriangles, kTriangleStrip, kTriangleFan };

/// The header of a .glb holds 32 bits.
inline constexpr std::uint64_t kMaxFileBytes = 0xffffffff;

}  // namespace coppice::bake::gltf_code
