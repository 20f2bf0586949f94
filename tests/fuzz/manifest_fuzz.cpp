// libFuzzer: any bytes as the list of `coppice bake-all` are refused with a named error, or list plants whose outputs stay below the output
// folder and whose options are a bake's.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "bake_key.h"
#include "batch_manifest.h"
#include "check.h"
#include "scratch_file.h"

namespace {

const std::filesystem::path kOutputs = "/nowhere/out";

void check_plant(const coppice::bake::BatchPlant& plant) {
  const std::filesystem::path below = plant.output.lexically_relative(kOutputs);
  COPPICE_ASSERT(!below.empty() && below != "." && *below.begin() != "..");
  COPPICE_ASSERT(plant.output.has_filename() && !plant.input.empty());
  COPPICE_ASSERT(std::isfinite(plant.options.import.metres_per_unit));
  COPPICE_ASSERT(!coppice::bake::option_parts(plant.options).empty());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path manifest = coppice::test::scratch_file("list.json", {data, size});
  const auto plants = coppice::bake::plants_of_manifest(manifest, kOutputs, {});
  if (!plants) {
    COPPICE_ASSERT(!plants.error().message().empty());
    return 0;
  }
  COPPICE_ASSERT(!plants->empty());
  for (const coppice::bake::BatchPlant& plant : *plants) check_plant(plant);
  if (const auto checked = coppice::bake::check_batch(*plants); !checked) COPPICE_ASSERT(!checked.error().message().empty());
  return 0;
}
