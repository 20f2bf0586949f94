// Changes to SPIR-V before a pipeline is made of it.

#include "gpu/device/shader_words.h"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

namespace coppice::gpu {
namespace {

using Words = std::vector<std::uint32_t>;

constexpr std::uint32_t kDecorate = 71, kSpecId = 1, kLabel = 248, kSelectionMerge = 247, kBranch = 249, kBranchConditional = 250;
constexpr std::uint32_t kReads = 20, kOther = 21;  // bools with these constants' ids 8 and 9

Words op(std::uint32_t opcode, std::initializer_list<std::uint32_t> operands) {
  Words words{static_cast<std::uint32_t>(operands.size() + 1) << 16 | opcode};
  words.insert(words.end(), operands);
  return words;
}

Words module(std::initializer_list<Words> ops) {
  Words words{0x07230203, 0x10600, 0, 100, 0};
  for (const Words& one : ops) words.insert(words.end(), one.begin(), one.end());
  return words;
}

TEST(ShaderWords, BranchesOnTheConstantAloneGoToWhereItIsFalse) {
  const Words reads = op(kDecorate, {kReads, kSpecId, 8}), other = op(kDecorate, {kOther, kSpecId, 9});
  const Words other_merge = op(kSelectionMerge, {33, 0}), other_branch = op(kBranchConditional, {kOther, 31, 32});
  const Words before = module({reads, other, op(kSelectionMerge, {43, 0}), op(kBranchConditional, {kReads, 41, 42}), op(kLabel, {41}),
                               op(kBranch, {43}), op(kLabel, {42}), other_merge, other_branch});
  const Words after =
      module({reads, other, op(kBranch, {42}), op(kLabel, {41}), op(kBranch, {43}), op(kLabel, {42}), other_merge, other_branch});
  EXPECT_EQ(without_branches(before, 8), after);
}

TEST(ShaderWords, AModuleWithoutTheConstantStays) {
  const Words words = module({op(kSelectionMerge, {43, 0}), op(kBranchConditional, {50, 41, 42})});
  EXPECT_EQ(without_branches(words, 8), words);
}

}  // namespace
}  // namespace coppice::gpu
