#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "made_once.h"
#include "tool.h"

namespace coppice::test {

/// A copy of corylus, baked small: quick, and looks are judged elsewhere.
inline std::filesystem::path bake_corylus(const TemporaryFolder& folder, const Words& options = {}) {
  std::string name = "corylus_small";
  for (const std::string& option : options) name += option;
  const std::filesystem::path made = made_once(name, [&](const std::filesystem::path& kept) {
    const ProcessResult baked =
        run_tool(joined({"bake", corylus_glb(), "-o", kept / "corylus.coppice", "--resolution", "64", "--quiet"}, options));
    if (baked.exit_code != 0) throw std::runtime_error("coppice bake: " + baked.err);
  });
  std::filesystem::copy_file(made / "corylus.coppice", folder / "corylus.coppice", std::filesystem::copy_options::overwrite_existing);
  return folder / "corylus.coppice";
}

}  // namespace coppice::test
