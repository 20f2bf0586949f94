#pragma once

#include <cstdint>

// The numbers of a glTF 2.0 document: `componentType` of accessors, `mode` of primitives, and the largest size of a file.

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

/// The header of a .glb holds its size in 32 bits.
inline constexpr std::uint64_t kMaxFileBytes = 0xffffffff;

}  // namespace coppice::bake::gltf_code
