// coppice-forest: a forest of streamed plants, in a window or headless. What it does is in `coppice-forest --help`.
#include <malloc.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <new>

#include "app.h"
#include "doctor.h"
#include "trial.h"

namespace {

/// A table or a help text that nobody could read is no success.
int finish(int exit_code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  std::fprintf(stderr, "coppice-forest: cannot write to the standard output: %s\n", std::strerror(errno));
  return exit_code == 0 ? 1 : exit_code;
}

/// The exit code of `run`, which throws whatever keeps it from its end.
int guarded(const std::function<int()>& run) {
  int exit_code = 1;
  try {
    exit_code = run();
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "coppice-forest: out of memory\n");
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "coppice-forest: %s\n", failure.what());
  }
  return finish(exit_code);
}

}  // namespace

int main(int argc, char** argv) {
  // Software Vulkan frees and faults in its scene memory every frame otherwise, which doubles the time of a frame at random.
  mallopt(M_TRIM_THRESHOLD, 2'000'000'000);
  mallopt(M_TOP_PAD, 64 << 20);
  if (argc == 4 && std::strcmp(argv[1], forest::kTrialOption) == 0)
    return guarded([&] {
      forest::run_trial(argv[2], std::strtod(argv[3], nullptr));
      return 0;
    });
  const forest::ParsedOptions parsed = forest::parse_options(argc, argv);
  if (parsed.exit_code) return finish(*parsed.exit_code);
  return guarded([&] {
    return parsed.options.doctor ? forest::run_doctor(parsed.options.doctor_limit_s, forest::version()) : forest::run(parsed.options);
  });
}
