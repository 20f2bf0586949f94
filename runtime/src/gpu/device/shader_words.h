#pragma once

// Changes to SPIR-V before a pipeline is made of it.

#include <cstdint>
#include <span>
#include <vector>

namespace coppice::gpu {

/// The shader without what it would write to attachments from `color_count` on: those outputs become variables of its own. Fragment shaders
/// declare an output for each attachment that a view may have; most views have fewer. Vulkan drops what no attachment takes, but validation
/// warns of it in classic render passes.
/// words  SPIR-V 1.4 or newer of a fragment shader, as glslang writes it
std::vector<std::uint32_t> with_outputs(std::span<const std::uint32_t> words, std::uint32_t color_count);

/// The shader without the branches that run where the bool of this constant id is true. Drivers drop them as well, but SwiftShader takes
/// two minutes for what it compiles in half a second without them.
std::vector<std::uint32_t> without_branches(std::span<const std::uint32_t> words, std::uint32_t constant_id);

}  // namespace coppice::gpu
