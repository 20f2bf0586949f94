#include "bake_batch.h"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <new>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "gltf_builder.h"
#include "inspect.h"
#include "job_processes.h"
#include "mentions.h"
#include "process.h"

namespace coppice::bake {
namespace bake_batch_test {

namespace fs = std::filesystem;

// First those that copy the process: they must do so before TBB has threads in it.

TEST(RunJobs, OneThatFailsTakesNoOtherWithIt) {
  std::vector<JobEnd> ends(6);
  std::vector<double> progress(6, 0.0);
  JobCallbacks callbacks;
  callbacks.run = [](std::size_t job, const JobProgress& report) -> std::string {
    report(0.5);
    if (job == 1) ::raise(SIGKILL);
    if (job == 2) throw std::bad_alloc();
    if (job == 3) throw std::runtime_error("a reason");
    if (job == 4) ::_exit(3);
    return std::string(100'000, static_cast<char>('a' + job));
  };
  callbacks.progressed = [&](std::size_t job, double fraction) { progress[job] = fraction; };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) { ends[job] = end; };
  run_jobs(6, 2, callbacks);
  EXPECT_EQ(ends[0].result, std::string(100'000, 'a'));
  EXPECT_EQ(ends[5].result, std::string(100'000, 'f'));
  EXPECT_EQ(ends[0].failure, "");
  EXPECT_TRUE(test::mentions(ends[1].failure, {strsignal(SIGKILL)}));
  EXPECT_TRUE(test::mentions(ends[2].failure, {"memory"}));
  EXPECT_EQ(ends[3].failure, "a reason");
  EXPECT_NE(ends[4].failure, "");
  EXPECT_EQ(progress, std::vector<double>(6, 0.5));
  EXPECT_GT(ends[0].peak_rss_bytes, 100'000u);
}

TEST(RunJobs, OneThatTakesTooLongIsEnded) {
  std::vector<JobEnd> ends(3);
  JobCallbacks callbacks;
  callbacks.run = [](std::size_t job, const JobProgress&) -> std::string {
    for (volatile bool busy = job == 1; busy;) {
    }
    return "done";
  };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) { ends[job] = end; };
  run_jobs(3, 2, callbacks, {.memory_bytes = 0, .seconds = 2.5});
  EXPECT_EQ(ends[0].result, "done");
  EXPECT_TRUE(test::mentions(ends[1].failure, {"2.5", "--max-seconds"}));
  EXPECT_EQ(ends[2].result, "done") << "the time of each job is its own";
}

TEST(RunJobs, NoMoreAtATimeThanAsked) {
  const test::TemporaryFolder folder;
  std::size_t most = 0;
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t job, const JobProgress&) {
    const std::string name = std::to_string(job);
    test::write_file(folder / name.c_str(), std::vector<std::uint8_t>(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const auto count = std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator());
    fs::remove(folder / name.c_str());
    return std::to_string(count);
  };
  callbacks.ended = [&](std::size_t, const JobEnd& end) { most = std::max<std::size_t>(most, std::stoul(end.result)); };
  run_jobs(5, 1, callbacks);
  EXPECT_EQ(most, 1u);
  run_jobs(6, 3, callbacks);
  EXPECT_GE(most, 2u) << "they did not run at the same time";
  EXPECT_LE(most, 3u);
}

BakeOptions quick_options() {
  BakeOptions options;
  options.view_count = 2;
  options.collapse.resolution_px = 16;
  return options;
}

TEST(BakeBatch, ResultsAreInTheOrderOfThePlants) {
  const test::TemporaryFolder folder;
  test::write_file(folder / "a.glb", std::vector<std::uint8_t>(9000));  // not a plant, and the largest
  test::write_file(folder / "b.glb", test::small_plant().glb());
  std::vector<BatchPlant> plants;
  for (const char* name : {"a", "b"})
    plants.push_back(
        {folder / (std::string(name) + ".glb").c_str(), folder / "out/deep" / (std::string(name) + ".coppice"), quick_options()});
  BatchStatus last;
  const auto results = bake_batch(plants, {folder / "cache", 2}, [&](const BatchStatus& status) { last = status; });
  ASSERT_TRUE(results) << results.error().message();
  ASSERT_EQ(results->size(), 2u);
  EXPECT_EQ((*results)[0].outcome, BatchOutcome::failed);
  EXPECT_NE((*results)[0].error.find("a.glb"), std::string::npos) << (*results)[0].error;
  EXPECT_EQ((*results)[1].outcome, BatchOutcome::baked);
  EXPECT_EQ((*results)[1].source_leaves, 1u);
  EXPECT_FALSE(fs::exists(plants[0].output));
  EXPECT_TRUE(verify(*read_file(plants[1].output)));
  EXPECT_EQ(last.ended, 2u);
  EXPECT_EQ(last.fraction, 1.0);
}

TEST(BatchPlants, OneWhoseVariantsCannotBeListedFails) {
  const test::TemporaryFolder folder;
  BatchPlant plant{folder / "oak.glb", folder / "oak.coppice", quick_options(), true};
  test::write_file(plant.input, test::small_plant().glb());
  ASSERT_EQ(expand_variants({plant}, {}).size(), 1u);
  EXPECT_EQ(expand_variants({plant}, {})[0].failure, "");
  constexpr std::size_t kMoreThanTheHeapHas = std::size_t{64} << 20;
  test::write_file(plant.input, std::vector<std::uint8_t>(kMoreThanTheHeapHas));
  const auto expanded = expand_variants({plant}, {.memory_bytes = 1});
  ASSERT_EQ(expanded.size(), 1u);
  EXPECT_NE(expanded[0].failure, "");  // its words are the memory limit's, or those of a sanitizer that ended the process
  const auto results = bake_batch(expanded, {folder / "cache", 1, {}}, nullptr);
  ASSERT_TRUE(results) << results.error().message();
  EXPECT_EQ((*results)[0].outcome, BatchOutcome::failed);
  EXPECT_EQ((*results)[0].error, expanded[0].failure);
  EXPECT_FALSE(fs::exists(plant.output));
}

TEST(BatchPlants, AreFoundInEveryFolderAndSorted) {
  const test::TemporaryFolder folder;
  const fs::path root = folder / "plants";
  for (const char* name : {"b.glb", "a/c.GLTF", "a/notes.txt", "a.b/d.gltf", "z.coppice"}) {
    fs::create_directories((root / name).parent_path());
    test::write_file(root / name, std::vector<std::uint8_t>(3));
  }
  fs::create_directory(root / "folder.glb");
  const auto plants = plants_of_folder(root, "out", quick_options());
  ASSERT_TRUE(plants) << plants.error().message();
  std::vector<std::pair<fs::path, fs::path>> found;
  for (const BatchPlant& plant : *plants) found.emplace_back(plant.input.lexically_relative(root), plant.output);
  EXPECT_EQ(found, (std::vector<std::pair<fs::path, fs::path>>{
                       {"a/c.GLTF", "out/a/c.coppice"}, {"a.b/d.gltf", "out/a.b/d.coppice"}, {"b.glb", "out/b.coppice"}}));
  EXPECT_TRUE(check_batch(*plants));

  test::write_file(root / "b.gltf", std::vector<std::uint8_t>(3));
  const auto colliding = check_batch(*plants_of_folder(root, "out", quick_options()));
  ASSERT_FALSE(colliding);
  EXPECT_TRUE(test::mentions(colliding.error().message(), {"b.glb", "b.gltf", "b.coppice"}));
  EXPECT_FALSE(check_batch({{root / "b.glb", root / "a" / ".." / "b.glb", {}}})) << "an output over its input";
  EXPECT_FALSE(plants_of_folder(root / "folder.glb", "out", {})) << "nothing in it";
  EXPECT_FALSE(plants_of_folder(root / "nowhere", "out", {}));
  test::write_file(root / "folder.glb" / "pine.OBJ", std::vector<std::uint8_t>(3));
  const auto other = plants_of_folder(root / "folder.glb", "out", {});
  ASSERT_FALSE(other);
  EXPECT_TRUE(test::mentions(other.error().message(), {"wm.obj_import", "pine.OBJ"}));
}

class BakeCached : public testing::Test {
 protected:
  void SetUp() override { write_plant(1); }
  /// Plants of other sizes.
  void write_plant(int scale) {
    test::GltfBuilder builder = test::small_plant();
    builder.json["nodes"][0]["scale"] = {scale, scale, scale};
    test::write_file(plant_.input, builder.glb());
  }
  BatchResult bake() {
    return bake_cached(plant_, cache_, [](const char*, double) {});
  }
  std::vector<std::uint8_t> output() { return *read_file(plant_.output); }

  test::TemporaryFolder folder_;
  fs::path cache_ = folder_ / "cache";
  BatchPlant plant_{folder_ / "plant.glb", folder_ / "plant.coppice", quick_options()};
};

TEST_F(BakeCached, AnOlderStateIsFoundAgain) {
  const BatchResult first = bake();
  ASSERT_EQ(first.outcome, BatchOutcome::baked) << first.error;
  const auto first_bytes = output();
  EXPECT_EQ(first.file_bytes, first_bytes.size());
  const auto written = fs::last_write_time(plant_.output);
  const BatchResult again = bake();
  EXPECT_EQ(again.outcome, BatchOutcome::cached);
  EXPECT_EQ(again.key, first.key);
  EXPECT_EQ(again.source_leaves, first.source_leaves);
  EXPECT_EQ(again.foliage_bytes, first.foliage_bytes);
  EXPECT_EQ(again.warnings, first.warnings);
  EXPECT_EQ(fs::last_write_time(plant_.output), written) << "an output that is right is left alone";

  write_plant(3);
  EXPECT_EQ(bake().outcome, BatchOutcome::baked);
  EXPECT_NE(output(), first_bytes);
  write_plant(1);
  EXPECT_EQ(bake().outcome, BatchOutcome::cached);
  EXPECT_EQ(output(), first_bytes);
  plant_.options.metric = Metric::geometric;
  EXPECT_EQ(bake().outcome, BatchOutcome::baked);
}

TEST_F(BakeCached, TheOutputIsMendedAndADamagedCacheIsBakedAgain) {
  const BatchResult first = bake();
  ASSERT_EQ(first.outcome, BatchOutcome::baked) << first.error;
  const auto bytes = output();
  test::write_file(plant_.output, std::vector<std::uint8_t>(7));
  EXPECT_EQ(bake().outcome, BatchOutcome::cached);
  EXPECT_EQ(output(), bytes);
  fs::remove(plant_.output);
  EXPECT_EQ(bake().outcome, BatchOutcome::cached);
  EXPECT_EQ(output(), bytes);

  std::vector<std::uint8_t> damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  test::write_file(cache_ / (first.key + ".coppice"), damaged);
  const BatchResult mended = bake();
  EXPECT_EQ(mended.outcome, BatchOutcome::baked);
  ASSERT_EQ(mended.warnings.size(), first.warnings.size() + 1);
  EXPECT_NE(mended.warnings[0].find(first.key), std::string::npos) << mended.warnings[0];
  EXPECT_EQ(output(), bytes);
  EXPECT_EQ(bake().outcome, BatchOutcome::cached);
}

TEST_F(BakeCached, WhatFailsIsNotKeptAndLeavesTheOutput) {
  ASSERT_EQ(bake().outcome, BatchOutcome::baked);
  const auto bytes = output();
  test::write_file(plant_.input, std::vector<std::uint8_t>(100));
  for (int i = 0; i < 2; ++i) {
    const BatchResult result = bake();
    EXPECT_EQ(result.outcome, BatchOutcome::failed);
    EXPECT_NE(result.error, "");
    EXPECT_EQ(output(), bytes);
  }
  fs::remove(plant_.input);
  EXPECT_EQ(bake().outcome, BatchOutcome::failed);
}

}  // namespace bake_batch_test
}  // namespace coppice::bake
