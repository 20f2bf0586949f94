// Plants, one for each cause of wrong pictures, beside themselves in full detail; under validation. COPPICE_LOOKS_PICTURES=1 writes all
// pictures, not only those of failures.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <optional>
#include <stdexcept>

#include "golden.h"
#include "looks_case.h"
#include "places.h"
#include "process.h"

namespace coppice::test {

std::filesystem::path bake_file(const std::filesystem::path& glb, const bake::BakeOptions& options) {
  bake::BakeReport report;
  const auto bytes = bake::bake(
      glb, options, [](const char*, double) {}, report);
  if (!bytes) throw std::runtime_error(bytes.error().message());
  for (const std::string& warning : report.warnings) std::printf("%s: %s\n", glb.stem().c_str(), warning.c_str());
  return write_file(std::filesystem::path(glb).replace_extension(".coppice"), *bytes);
}

std::filesystem::path bake_plant(const std::filesystem::path& folder, const std::string& name, const GltfBuilder& plant,
                                 const bake::BakeOptions& options) {
  return bake_file(write_file(folder / (name + ".glb"), plant.glb()), options);
}

namespace looks_test {

/// For plants of which full detail is looked at: no metric changes that.
bake::BakeOptions quick(bake::BakeOptions options) {
  options.metric = bake::Metric::geometric;
  return options;
}

bool writes_all_pictures() {
  const char* value = std::getenv("COPPICE_LOOKS_PICTURES");
  return value != nullptr && std::strcmp(value, "1") == 0;
}

/// What two pictures are of.
struct Compared {
  std::string name;
  const MeanPicture& reference;
  const MeanPicture& picture;
};

std::string write_pictures(const Compared& compared) {
  const std::filesystem::path folder = std::filesystem::path(test::kOutputFolder) / "looks";
  std::filesystem::create_directories(folder);
  const std::filesystem::path file = folder / (compared.name + ".png");
  write_png(file, side_by_side(compared.reference, compared.picture));
  return file;
}

void expect_alike(const Compared& compared, bool expected) {
  const LooksDifference difference = compare_looks(compared.reference, compared.picture);
  const std::string line = compared.name + ": " + describe(difference);
  std::printf("%s\n", line.c_str());
  const bool passed = looks_alike(difference) == expected;
  if (!passed || writes_all_pictures()) {
    const std::string file = write_pictures(compared);
    EXPECT_TRUE(passed) << line << (expected ? "" : "; the defect passes for the plant") << "\nreference, picture, difference: " << file;
  }
}

TEST_P(LooksTest, IsAsInFullDetail) {
  const LooksCase& tested = GetParam();
  const TemporaryFolder folder;
  const std::filesystem::path file = bake_plant(folder.path(), "plant", tested.plant(), tested.bake);
  LooksStage hardware(gpu(), file, LooksPath::hardware), compute(gpu(), file, LooksPath::compute);
  std::optional<LooksStage> plain;
  if (tested.reference) plain.emplace(gpu(), bake_plant(folder.path(), "reference", tested.reference(), quick({})), LooksPath::hardware);
  LooksStage& referenced = plain ? *plain : hardware;
  for (const float size_px : tested.sizes_px) {
    const auto named = [&](const char* what) {
      return std::string(tested.name) + "." + what + "." + std::to_string(static_cast<int>(size_px));
    };
    const LooksView cut{referenced.sphere(), size_px, tested.from};
    LooksView full = cut;
    full.lod = COPPICE_LOD_FULL;
    const MeanPicture reference = referenced.draw(full);
    expect_alike({named("hardware"), reference, hardware.draw(cut)}, true);
    expect_alike({named("compute"), reference, compute.draw(cut)}, true);
    if (size_px != tested.defect_size_px) continue;
    LooksStage defect(gpu(), bake_plant(folder.path(), "defect", tested.defect(), quick(tested.bake)), LooksPath::hardware);
    expect_alike({named("defect"), reference, defect.draw(full)}, false);
  }
}

}  // namespace looks_test
}  // namespace coppice::test
