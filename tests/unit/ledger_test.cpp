// What the ledger grants, refuses and remembers.

#include "ledger.h"

#include <gtest/gtest.h>

namespace coppice {
namespace ledger_test {

TEST(Ledger, GrantsWhatIsFreeAndNoMore) {
  Ledger ledger(100);
  EXPECT_TRUE(ledger.fits(100));
  ledger.reserve(60);
  EXPECT_EQ(ledger.free(), 40u);
  EXPECT_TRUE(ledger.fits(40));
  EXPECT_FALSE(ledger.fits(41));
  ledger.release(10);
  EXPECT_TRUE(ledger.fits(50));
  EXPECT_EQ(ledger.reserved(), 50u);
  EXPECT_EQ(ledger.max_reserved(), 60u);
}

TEST(Ledger, ASmallerBudgetLeavesWhatIsTaken) {
  Ledger ledger(100);
  ledger.reserve(60);
  ledger.set_budget(50);
  EXPECT_EQ(ledger.free(), 0u);
  EXPECT_EQ(ledger.reserved(), 60u);
  EXPECT_FALSE(ledger.fits(1));
  EXPECT_TRUE(ledger.fits(0));
}

TEST(Ledger, WantsTheMostThatItRefusedUntilThatIsGranted) {
  Ledger ledger(100);
  ledger.reserve(90);
  EXPECT_FALSE(ledger.fits(30));
  EXPECT_FALSE(ledger.fits(20));
  EXPECT_EQ(ledger.refused(), 30u);
  ledger.release(60);
  EXPECT_TRUE(ledger.fits(20));
  EXPECT_EQ(ledger.refused(), 30u) << "somebody else's";
  EXPECT_TRUE(ledger.fits(30));
  EXPECT_EQ(ledger.refused(), 0u);
}

TEST(Ledger, ForgetsARefusalThatIsNotRepeated) {
  Ledger ledger(10);
  ledger.begin_frame(1);
  EXPECT_FALSE(ledger.fits(30));
  for (std::uint64_t frame = 2; frame <= 40; ++frame) ledger.begin_frame(frame);
  EXPECT_FALSE(ledger.fits(30));
  ledger.begin_frame(40 + Ledger::kRefusalFrames);
  EXPECT_EQ(ledger.refused(), 30u);
  ledger.begin_frame(41 + Ledger::kRefusalFrames);
  EXPECT_EQ(ledger.refused(), 0u);
}

}  // namespace ledger_test
}  // namespace coppice
