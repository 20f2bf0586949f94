#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace coppice::test {

/// A folder of files that many cases read and none changes. The first that asks makes them with `make`; all others, in any process, find
/// them, until `coppice` itself is built anew. name  of the folder, which says what is in it Throws std::runtime_error when the folder
/// cannot be made, and what `make` throws.
std::filesystem::path made_once(const std::string& name, const std::function<void(const std::filesystem::path& folder)>& make);

/// Corylus as `coppice plant` gives it.
std::filesystem::path corylus_glb();

}  // namespace coppice::test
