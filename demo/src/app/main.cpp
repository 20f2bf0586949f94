// coppice-forest: a forest of streamed plants, in a window or headless. What it does is in `coppice-forest --help`.
#include <malloc.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>

#include "app.h"

namespace {

/// A table or a help text that nobody could read is no success.
int finish(int exit_code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  std::fprintf(stderr, "coppice-forest: cannot write to the standard output: %s\n", std::strerror(errno));
  return exit_code == 0 ? 1 : exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  // Software Vulkan frees and faults in its scene memory every frame otherwise, which doubles the time of a frame at random.
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  mallopt(M_TOP_PAD, 64 << 20);
  const forest::ParsedOptions parsed = forest::parse_options(argc, argv);
  if (parsed.exit_code) return finish(*parsed.exit_code);
  int exit_code = 1;
  try {
    exit_code = forest::run(parsed.options);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "coppice-forest: out of memory\n");
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "coppice-forest: %s\n", failure.what());
  }
  return finish(exit_code);
}
