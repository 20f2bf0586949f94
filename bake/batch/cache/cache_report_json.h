#pragma once

// What a cache did, as JSON: in a batch's report and a run's files, and on its way from the process that asks the cache.

#include <nlohmann/json.hpp>

#include "remote_cache.h"

namespace coppice::bake {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CacheReport, where, found, lacking, sent, requests, unasked, unsent, damaged, lost_seconds, gave_up,
                                   trouble)

}  // namespace coppice::bake
