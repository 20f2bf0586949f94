// What a program has run so far, for the preset `coverage`: clang sets a flag for each piece of the product that runs.
#pragma once

#include <filesystem>
#include <string>

namespace coppice::test {

// Where this process is to write, by the environment variable COPPICE_COVERAGE; empty: nowhere.
std::filesystem::path coverage_folder();

// Text "MODULE:INDEX ..." of the flags that are set.
std::string take_coverage();

}  // namespace coppice::test
