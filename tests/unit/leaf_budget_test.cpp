// The threshold that follows a leaf budget, against forests made of a formula.
#include "leaf_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace coppice::leaf_budget_test {

constexpr float kErrorPx = 2.0f;
constexpr std::uint32_t kBudget = 100'000;

struct Walk {
  std::vector<float> thresholds_px;
  std::vector<double> leaves;
};

/// Frames whose counts arrive `latency` frames later. leaves: of a frame at a threshold
Walk walk(std::uint64_t frame_count, std::uint64_t latency, std::uint32_t budget,
          const std::function<double(std::uint64_t, float)>& leaves) {
  LeafBudget controller;
  Walk result;
  for (std::uint64_t frame = 1; frame <= frame_count; ++frame) {
    if (frame > latency)
      controller.observe({.frame = frame - latency, .leaves = static_cast<std::uint64_t>(result.leaves[frame - latency - 1])});
    const float threshold_px = controller.threshold_px(frame, kErrorPx, budget);
    result.thresholds_px.push_back(threshold_px);
    result.leaves.push_back(leaves(frame, threshold_px));
  }
  return result;
}

/// A forest of so many leaves at the threshold that was asked for, which fall as a power of it.
std::function<double(std::uint64_t, float)> forest(double leaves, double power) {
  return [=](std::uint64_t, float threshold_px) { return leaves * std::pow(static_cast<double>(threshold_px / kErrorPx), -power); };
}

TEST(LeafBudget, WhatFitsIsDrawnAsAsked) {
  const Walk fits = walk(50, 2, kBudget, forest(0.99 * kBudget, 1.5));
  for (const float threshold_px : fits.thresholds_px) EXPECT_EQ(threshold_px, kErrorPx);
  const Walk unlimited = walk(50, 2, 0, forest(1e9, 1.5));
  for (const float threshold_px : unlimited.thresholds_px) EXPECT_EQ(threshold_px, kErrorPx);
}

TEST(LeafBudget, RisesUntilTheWorkFitsAndRests) {
  for (const double power : {1.0, 1.5, 2.0})
    for (const std::uint64_t latency : {1u, 2u, 4u}) {
      const Walk result = walk(200, latency, kBudget, forest(12.0 * kBudget, power));
      for (std::size_t i = 150; i < 200; ++i) {
        EXPECT_LE(result.leaves[i], kBudget * 1.0001) << power << ' ' << latency << ' ' << i;
        EXPECT_GE(result.leaves[i], kBudget * LeafBudget::kRest * 0.99) << power << ' ' << latency << ' ' << i;
        EXPECT_EQ(result.thresholds_px[i], result.thresholds_px[149]) << "it is at rest";
      }
      for (std::size_t i = 1; i < 200; ++i)
        EXPECT_LT(result.thresholds_px[i] / result.thresholds_px[i - 1], 1.2) << "little by little, frame " << i;
    }
}

TEST(LeafBudget, FallsBackOnceThereIsRoom) {
  const auto thicket = forest(8.0 * kBudget, 1.0), clearing = forest(0.2 * kBudget, 1.0);
  const Walk result =
      walk(400, 2, kBudget, [&](std::uint64_t frame, float px) { return frame < 150 ? thicket(frame, px) : clearing(frame, px); });
  EXPECT_GT(result.thresholds_px[148], 4.0f * kErrorPx);
  EXPECT_EQ(result.thresholds_px.back(), kErrorPx);
}

TEST(LeafBudget, ASlowWalkDoesNotMakeItSwing) {
  // Two per cent more and less in view over hundreds of frames.
  const Walk result = walk(600, 2, kBudget, [&](std::uint64_t frame, float px) {
    return forest((4.0 + 0.08 * std::sin(0.02 * static_cast<double>(frame))) * kBudget, 1.5)(frame, px);
  });
  int turns = 0;
  float last_step = 0.0f;
  for (std::size_t i = 101; i < 600; ++i) {
    const float step = result.thresholds_px[i] - result.thresholds_px[i - 1];
    if (step * last_step < 0.0f) ++turns;
    if (step != 0.0f) last_step = step;
    EXPECT_LE(result.leaves[i], 1.03 * kBudget) << i;
  }
  EXPECT_LE(turns, 2);
}

TEST(LeafBudget, TrianglesOfTheHardwareWeighMore) {
  EXPECT_EQ(work_in_leaves({.leaves = 10, .wood_triangles = 5}), 15.0);
  EXPECT_GT(work_in_leaves({.leaves = 10, .hardware_triangles = 20}), 50.0);
}

}  // namespace coppice::leaf_budget_test
