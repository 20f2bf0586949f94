#pragma once

// How tests name who reads files.

#include <ostream>

#include "hooks.h"

namespace coppice {

inline void PrintTo(Reading reading, std::ostream* out) {
  *out << (reading == Reading::automatic ? "automatic" : "thread_pool");
}

}  // namespace coppice
