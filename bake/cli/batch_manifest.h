#pragma once

#include <filesystem>
#include <vector>

#include "bake_batch.h"
#include "option_table.h"
#include "result.h"

namespace coppice::bake {

/// The plants that a manifest of `coppice bake-all` lists: a JSON array of objects with "input", a path beside the manifest; "output", a
/// path below output_folder (by default the input's, with the extension .coppice; its name alone where that is not below the manifest's
/// folder); and any option of bake_option_table(), with _ for -. "classes" is a file beside the manifest, or the rules themselves as a
/// text.
/// defaults  for options that an entry does not give
/// errors    `detail` names the place, as in "[2].metric". io; bad_file: not JSON, not such an array; invalid_argument: a key that is not
///           known, a value that its option does not take, an output outside output_folder. A path with control characters is a bad_file
Result<std::vector<BatchPlant>> plants_of_manifest(const std::filesystem::path& manifest, const std::filesystem::path& output_folder,
                                                   const BakeRequest& defaults);

/// The entry of a manifest, as JSON, that plants_of_manifest reads as the same plant whatever the defaults: every option is in it that has
/// a value.
/// output_folder  the plant's output is below it
/// errors         invalid_argument: a name that is not UTF-8, which JSON cannot hold, or has control characters
Result<std::string> manifest_entry(const BatchPlant& plant, const std::filesystem::path& output_folder);

}  // namespace coppice::bake
