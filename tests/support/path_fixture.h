#pragma once

// A context of a plant of 3,000 leaves on each of the paths that draw it.

#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "context_fixture.h"

namespace coppice::test {

struct Path {
  const char* name;
  VkBool32 compute_raster, int64_atomics;
};

inline void PrintTo(const Path& each, std::ostream* out) {
  *out << each.name;
}
inline std::string path_name(const testing::TestParamInfo<Path>& path) {
  return path.param.name;
}

/// Small leaves by the hardware, by compute shaders, and by those of a device without 64-bit atomics, whose draws have no counts either.
inline constexpr Path kHardwarePath{"hardware", VK_FALSE, VK_FALSE}, kComputePath{"compute", VK_TRUE, VK_TRUE},
    kTwoPassPath{"compute_two_passes", VK_TRUE, VK_FALSE};

/// Five rows of eight plants, from the origin backwards; each one's user data is its number, from 1 on, in all four bytes.
inline std::vector<coppice_placement> rows() {
  std::vector<coppice_placement> all;
  for (std::uint32_t i = 0; i < 40; ++i) {
    all.push_back(placement_at(glm::vec3(2.2f * static_cast<float>(i % 8) - 7.7f, 0.0f, -3.0f * static_cast<float>(i / 8))));
    all.back().user_data = 0x01020304u * (i + 1);
  }
  return all;
}

/// Fixture: ContextTest or what is derived from it.
template <class Context>
class PathTest : public Context, public testing::WithParamInterface<Path> {
 protected:
  void SetUp() override {
    Context::SetUp();
    path_ = temporary_plant({.leaf_count = 3000, .seed = 5}, "path_test");
    ContextDesc with = this->desc();
    with.compute_raster = GetParam().compute_raster;
    with.shader_int64_atomics = GetParam().int64_atomics && this->gpu().int64_atomics ? VK_TRUE : VK_FALSE;
    if (GetParam().compute_raster == VK_TRUE && GetParam().int64_atomics == VK_FALSE) with.draw_indirect_count = VK_FALSE;
    this->create(with);
    plant_ = this->open(path_);
  }
  void TearDown() override {
    std::filesystem::remove(path_);
    Context::TearDown();
  }

  std::string path_;
  coppice_plant plant_ = 0;
};

}  // namespace coppice::test
