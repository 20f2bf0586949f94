#pragma once

// A picture of each plant of a batch (baked_picture.h), kept under the plant's key beside the outputs, so that it is drawn once.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bake_batch.h"
#include "result.h"

namespace coppice::bake {

/// Where a batch that writes below `output_folder` keeps its pictures. It may be deleted at any time.
std::filesystem::path picture_folder(const std::filesystem::path& output_folder);

/// The picture of a plant in that folder, if the user or root drew it: what somebody else put there may be anything.
/// errors  those of read_kept_file
Result<std::vector<std::uint8_t>> read_picture(const std::filesystem::path& folder, const std::string& key);

/// Draws the output of a plant, unless read_picture has it. errors  io; out_of_memory; those of baked_picture
Result<void> draw_picture(const std::filesystem::path& output, const std::string& key, const std::filesystem::path& folder);

/// draw_picture for every plant that has an output and no picture, each in a process of its own, so many at a time.
/// returns  of each plant, why it has no picture; empty
/// thread  the process must have no other threads (job_processes.h)
std::vector<std::string> draw_missing_pictures(const std::vector<BatchPlant>& plants, const std::vector<BatchResult>& results,
                                               const std::filesystem::path& folder, std::size_t at_a_time);

}  // namespace coppice::bake
