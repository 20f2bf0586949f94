#pragma once

// Fragment shaders declare an output for each attachment that a view may have; most views have fewer.

#include <cstdint>
#include <span>
#include <vector>

namespace coppice::gpu {

/// The shader without what it would write to attachments from `color_count` on: those outputs become variables of its own. Vulkan drops
/// what no attachment takes, but validation warns of it in classic render passes.
/// words  SPIR-V 1.4 or newer of a fragment shader, as glslang writes it
std::vector<std::uint32_t> with_outputs(std::span<const std::uint32_t> words, std::uint32_t color_count);

}  // namespace coppice::gpu
