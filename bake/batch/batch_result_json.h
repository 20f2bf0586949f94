#pragma once

// What became of a plant, as JSON on its way from the process that did it. Reports and journals have plant_record.

#include <nlohmann/json.hpp>

#include "bake_batch.h"

namespace coppice::bake {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(BatchResult, outcome, error, key, source_leaves, file_bytes, foliage_bytes, seconds, peak_rss_bytes,
                                   warnings, cache_failure, because, lost)

}  // namespace coppice::bake
