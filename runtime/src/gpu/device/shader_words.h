#pragma once

// Edits SPIR-V before a pipeline is made of it.

#include <cstdint>
#include <span>
#include <vector>

namespace coppice::gpu {

/// Removes outputs to attachments from `color_count` on: they become variables of the shader. Fragment shaders declare an output for each
/// attachment that a view may have, but most views have fewer. Vulkan drops outputs without an attachment, but validation warns of them in
/// classic render passes.
/// words  SPIR-V 1.4 or newer of a fragment shader, as glslang writes it
std::vector<std::uint32_t> with_outputs(std::span<const std::uint32_t> words, std::uint32_t color_count);

/// Removes branches that run only if the bool of this constant id is true. Drivers drop them too, but SwiftShader takes two minutes for a
/// shader that it compiles in half a second without them.
std::vector<std::uint32_t> without_branches(std::span<const std::uint32_t> words, std::uint32_t constant_id);

}  // namespace coppice::gpu
