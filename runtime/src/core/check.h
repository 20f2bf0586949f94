#pragma once

#include <cstdio>

/// Checks for a defect of ours in every build; never used on data from a file or a caller.
#define COPPICE_ASSERT(condition)                                                                       \
  do {                                                                                                  \
    if (!(condition)) {                                                                                 \
      std::fprintf(stderr, "coppice: assertion failed at %s:%d: %s\n", __FILE__, __LINE__, #condition); \
      __builtin_trap();                                                                                 \
    }                                                                                                   \
  } while (false)
