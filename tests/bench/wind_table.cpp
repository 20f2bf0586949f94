// What wind does to plants: how far the tip goes in 3, 8 and 15 m/s; in a gale of 25 m/s, how far leaves move, whether they stay on their
// twigs, whether crowns breathe. wind_figures.h says what each column is.
//   wind_table [PLANT.glb ...]   the three generated plants, then those

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "generate_plant.h"
#include "import_gltf.h"
#include "wind_figures.h"

namespace {

void print_row(const std::string& name, coppice::Result<coppice::bake::Plant> plant) {
  if (!plant) {
    std::printf("| %s | %s |\n", name.c_str(), plant.error().message().c_str());
    return;
  }
  try {
    const coppice::test::WindFigures of = coppice::test::wind_figures(std::move(*plant));
    std::printf("| %s | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f | %.1f %% | %.1f %% | %.2f | %.2f | %.2f | %.2f | %.1f |\n",
                name.c_str(), of.radius_m, 100 * of.tip_shares[0], 100 * of.tip_shares[1], 100 * of.tip_shares[2], 100 * of.stretch_max,
                100 * of.move_median_m, 100 * of.move_max_m, 100 * of.reach_m, 100 * of.reach_m / of.radius_m, 100 * of.growth,
                100 * of.gap_median, 100 * of.gap_99, 100 * of.gap_max, 100 * of.volume_max, 100 * of.squeeze_max);
  } catch (const std::exception& failure) {
    std::printf("| %s | %s |\n", name.c_str(), failure.what());
  }
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** words) {
  std::printf(
      "| plant | radius, m | tip, %% of the height: 3 m/s | 8 m/s | 15 m/s | stretch, %% | median leaf, cm | farthest leaf, cm | reach, cm "
      "| of the radius | growth | gap: median, %% of the leaf | 99 "
      "of 100 "
      "| most | volume of the crown, %% | about a leaf, %% |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | "
      "--- | --- "
      "| --- | --- |\n");
  for (const char* species : {"corylus", "willow", "juniper"}) print_row(species, coppice::bake::generate_plant(species, 1));
  for (int i = 1; i < count; ++i) print_row(std::filesystem::path(words[i]).stem().string(), coppice::bake::import_gltf(words[i], {}));
  return 0;
}
