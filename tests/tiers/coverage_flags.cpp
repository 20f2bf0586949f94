// clang's hooks of -fsanitize-coverage=inline-bool-flag,pc-table. A program that a test starts writes what it ran when it exits.
#include "coverage_flags.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <span>
#include <vector>

extern "C" {
extern const bool coppice_coverage;  // by which every program asks for this file
const bool coppice_coverage = true;
void __sanitizer_cov_bool_flag_init(bool* begin, bool* end);
void __sanitizer_cov_pcs_init(const std::uintptr_t* begin, const std::uintptr_t* end);
}

namespace coppice::test {
namespace {

// A program or a shared library. `flags[i]` is for the piece at `places[2 * i]`, an address; `places[2 * i + 1]` says what clang knows of
// it.
struct Module {
  std::string path;
  std::uintptr_t base;  // where it is in memory
  std::span<bool> flags;
  std::span<const std::uintptr_t> places;
};

// Each file of a module adds it when it starts: whole once main() has begun.
std::vector<Module>& modules() {
  static auto* made = new std::vector<Module>;  // outlives every destructor
  return *made;
}

Module& module_of(const void* address) {
  Dl_info info{};
  dladdr(address, &info);
  const auto base = reinterpret_cast<std::uintptr_t>(info.dli_fbase);
  for (Module& module : modules())
    if (module.base == base) return module;
  return modules().emplace_back(Module{std::filesystem::canonical(info.dli_fname), base, {}, {}});
}

// A test's own program has a listener that writes after each case.
struct AtExit {
  ~AtExit() {
    const std::filesystem::path folder = coverage_folder();
    if (folder.empty()) return;
    const std::string ran = take_coverage();
    if (!ran.empty()) std::ofstream(folder / ("process." + std::to_string(getpid()))) << ran;
  }
} at_exit;

}  // namespace

std::filesystem::path coverage_folder() {
  const char* folder = std::getenv("COPPICE_COVERAGE");
  return folder ? folder : "";
}

std::string take_coverage() {
  std::string text;
  for (const Module& module : modules()) {
    const std::string name = std::filesystem::path(module.path).filename();
    // The addresses are those of every process that runs the module: written once.
    const std::filesystem::path places = coverage_folder() / (name + ".places");
    if (!exists(places)) {
      std::ofstream out(places);
      out << module.path << '\n' << std::hex;
      for (std::size_t i = 0; i < module.places.size(); i += 2) out << "0x" << module.places[i] - module.base << '\n';
    }
    for (std::size_t i = 0; i < module.flags.size(); ++i) {
      if (!module.flags[i]) continue;
      module.flags[i] = false;
      text += name + ':' + std::to_string(i) + ' ';
    }
  }
  return text;
}

}  // namespace coppice::test

void __sanitizer_cov_bool_flag_init(bool* begin, bool* end) {
  coppice::test::module_of(begin).flags = {begin, end};
}

void __sanitizer_cov_pcs_init(const std::uintptr_t* begin, const std::uintptr_t* end) {
  coppice::test::module_of(begin).places = {begin, end};
}
