// What a program has run so far, for the preset `coverage`: clang sets a flag for each piece of the product that runs.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace coppice::test {

// A program or a shared library. `flags[i]` is for the piece at `places[2 * i]`, an address; `places[2 * i + 1]` says what clang knows of
// it.
struct CoverageModule {
  std::string path;
  std::uintptr_t base;  // where it is in memory
  std::span<bool> flags;
  std::span<const std::uintptr_t> places;
};

// Those of this process. Not before main(): each file of a module adds it when it starts.
std::span<const CoverageModule> coverage_modules();

// Where this process is to write, by the environment variable COPPICE_COVERAGE; empty: nowhere.
std::filesystem::path coverage_folder();

// Text "MODULE:INDEX ..." of the flags that are set.
std::string take_coverage();

}  // namespace coppice::test
