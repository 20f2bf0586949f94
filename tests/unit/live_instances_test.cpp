// Bulk calls with handles of which some are dead, through coppice.h.

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "coppice/coppice.h"
#include "host.h"

namespace coppice::test::live_instances_test {

class LiveInstances : public testing::Test {
 protected:
  LiveInstances() {
    for (std::size_t i = 0; i < handles.size(); ++i) handles[i] = host.add(plant, static_cast<float>(i), -3);
  }

  std::uint32_t is_live(coppice_instance instance) {
    std::uint32_t live = 7;
    EXPECT_EQ(coppice_instance_is_live(host.context(), instance, &live), COPPICE_OK);
    return live;
  }
  std::uint32_t instance_count() {
    host.frame();
    return host.stats().instance_count;
  }

  Host host;
  coppice_plant plant = host.open("two_pages.coppice");
  std::array<coppice_instance, 4> handles{};
};

TEST_F(LiveInstances, AHandleIsLiveUntilItsInstanceGoes) {
  for (const coppice_instance handle : handles) EXPECT_EQ(is_live(handle), COPPICE_TRUE);
  ASSERT_EQ(coppice_instances_remove(host.context(), &handles[1], 1), COPPICE_OK);
  EXPECT_EQ(is_live(handles[1]), COPPICE_FALSE);
  EXPECT_EQ(is_live(handles[2]), COPPICE_TRUE);
  const coppice_instance next = host.add(plant, 9, -3);
  EXPECT_EQ(is_live(handles[1]), COPPICE_FALSE) << "its index is in use again";
  EXPECT_EQ(is_live(next), COPPICE_TRUE);
  for (const coppice_instance garbage : {coppice_instance{0}, coppice_instance{plant}, ~coppice_instance{0}})
    EXPECT_EQ(is_live(garbage), COPPICE_FALSE) << garbage;
  Host other;
  EXPECT_EQ(is_live(other.add(other.open("two_pages.coppice"), 0, -3)), COPPICE_FALSE) << "of another context";
  coppice_plant_close(host.context(), plant);
  EXPECT_EQ(is_live(next), COPPICE_FALSE);
}

TEST_F(LiveInstances, DeadOnesAreSkippedAndCounted) {
  ASSERT_EQ(coppice_instances_remove(host.context(), &handles[1], 1), COPPICE_OK);
  auto placements = std::array<coppice_placement, 4>{};
  for (std::size_t i = 0; i < placements.size(); ++i) {
    coppice_placement_init(&placements[i]);
    placements[i].position[1] = -1;
    placements[i].position[2] = -10.0 - static_cast<double>(i);
  }
  placements[1].scale = 0;  // nobody's
  std::uint32_t skipped = 7;
  ASSERT_EQ(coppice_instances_move_live(host.context(), handles.data(), placements.data(), sizeof placements[0], 4, &skipped), COPPICE_OK)
      << coppice_last_error(host.context());
  EXPECT_EQ(skipped, 1u);
  host.settle();
  const std::vector<coppice_draw> draws = host.draws();
  ASSERT_EQ(draws.size(), 3u);
  for (const coppice_draw& draw : draws) EXPECT_LE(draw.position[2], -10.0);

  const std::array again{handles[0], handles[1], handles[2], handles[2]};
  ASSERT_EQ(coppice_instances_remove_live(host.context(), again.data(), 4, &skipped), COPPICE_OK);
  EXPECT_EQ(skipped, 2u) << "the dead one, and one that was given twice";
  EXPECT_EQ(instance_count(), 1u);
  EXPECT_EQ(is_live(handles[3]), COPPICE_TRUE);
  EXPECT_EQ(coppice_instances_remove_live(host.context(), handles.data(), 4, nullptr), COPPICE_OK) << "nobody asks how many";
  EXPECT_EQ(instance_count(), 0u);
}

TEST_F(LiveInstances, ABadPlacementOfALiveOneMovesNone) {
  ASSERT_EQ(coppice_instances_remove(host.context(), &handles[0], 1), COPPICE_OK);
  std::array<coppice_placement, 2> placements{};
  for (coppice_placement& placement : placements) coppice_placement_init(&placement);
  placements[0].position[2] = placements[1].position[2] = -20;
  placements[1].lod_bias = 5;
  const std::array two{handles[2], handles[3]};
  std::uint32_t skipped = 7;
  EXPECT_EQ(coppice_instances_move_live(host.context(), two.data(), placements.data(), sizeof placements[0], 2, &skipped),
            COPPICE_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(skipped, 0u);
  EXPECT_NE(std::string(coppice_last_error(host.context())).find("placements[1].lod_bias"), std::string::npos)
      << coppice_last_error(host.context());
  host.settle();
  for (const coppice_draw& draw : host.draws()) EXPECT_EQ(draw.position[2], -3.0);
}

}  // namespace coppice::test::live_instances_test
