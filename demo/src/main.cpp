// coppice-forest: a forest of streamed plants, in a window or headless. What it does is in `coppice-forest --help`.
#include <malloc.h>

#include <cstdio>

#include "app.h"
#include "failure.h"

int main(int argc, char** argv) {
  // Software Vulkan frees and faults in its scene memory every frame otherwise, which doubles the time of a frame at random.
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  mallopt(M_TOP_PAD, 64 << 20);
  const forest::ParsedOptions parsed = forest::parse_options(argc, argv);
  if (parsed.exit_code) return *parsed.exit_code;
  try {
    return forest::run(parsed.options);
  } catch (const forest::Failure& failure) {
    std::fprintf(stderr, "coppice-forest: %s\n", failure.what());
    return 1;
  }
}
