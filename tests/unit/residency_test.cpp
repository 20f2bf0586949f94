#include "residency.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace coppice::residency_test {

using enum Residency;

/// The table of ARCHITECTURE.md, written out once more.
const std::set<std::pair<Residency, Residency>> kTable = {
    {absent, reading},    {reading, absent},  {reading, decoding}, {reading, failed},   {decoding, absent},
    {decoding, decoded},  {decoding, failed}, {decoded, absent},   {decoded, resident}, {decoded, failed},
    {resident, evicting}, {evicting, absent}, {failed, absent},
};

TEST(Residency, AllowsTheTableAndRefusesEverythingElse) {
  for (std::uint32_t i = 0; i < kResidencyCount; ++i)
    for (std::uint32_t j = 0; j < kResidencyCount; ++j) {
      const auto from = static_cast<Residency>(i), to = static_cast<Residency>(j);
      const bool legal = kTable.contains({from, to});
      Chunk chunk;
      chunk.residency = from;
      EXPECT_EQ(may_advance(from, to), legal) << residency_name(from) << " -> " << residency_name(to);
      EXPECT_EQ(advance(chunk, to), legal) << residency_name(from) << " -> " << residency_name(to);
      EXPECT_EQ(chunk.residency, legal ? to : from) << residency_name(from) << " -> " << residency_name(to);
    }
}

}  // namespace coppice::residency_test
