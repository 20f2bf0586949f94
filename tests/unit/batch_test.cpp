// Batches: jobs in processes, plants of folders, the cache of an output folder; plans of tasks and shards, costs, journals, and the text
// that Slurm gets and prints.

#include <sys/fsuid.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <map>
#include <new>
#include <numeric>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "atomic_file.h"
#include "bake_batch.h"
#include "gltf_builder.h"
#include "inspect.h"
#include "job_processes.h"
#include "mentions.h"
#include "plant_cost.h"
#include "plant_pictures.h"
#include "plant_record.h"
#include "process.h"
#include "results.h"
#include "slurm.h"

namespace coppice::bake::batch_test {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

// First those that copy the process: they must do so before TBB has threads in it.

struct Jobs {
  std::vector<JobEnd> ends;
  std::vector<double> progress;
};

Jobs run_all(std::size_t count, std::size_t at_a_time, decltype(JobCallbacks::run) run, const JobLimits& limits = {}) {
  Jobs jobs{std::vector<JobEnd>(count), std::vector<double>(count)};
  JobCallbacks callbacks;
  callbacks.run = std::move(run);
  callbacks.progressed = [&](std::size_t job, double fraction) { jobs.progress[job] = fraction; };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) { jobs.ends[job] = end; };
  run_jobs(count, at_a_time, callbacks, limits);
  return jobs;
}

TEST(RunJobs, OneThatFailsTakesNoOtherWithIt) {
  const auto [ends, progress] = run_all(6, 2, [](std::size_t job, const JobProgress& report) -> std::string {
    report(0.5);
    if (job == 1) ::raise(SIGKILL);
    if (job == 2) throw std::bad_alloc();
    if (job == 3) throw std::runtime_error("a reason");
    if (job == 4) ::_exit(3);
    return std::string(100'000, static_cast<char>('a' + job));
  });
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
  const auto run = [](std::size_t job, const JobProgress&) -> std::string {
    for (volatile bool busy = job == 1; busy;) {
    }
    return "done";
  };
  const std::vector<JobEnd> ends = run_all(3, 2, run, {.memory_bytes = 0, .seconds = 2.5}).ends;
  EXPECT_EQ(ends[0].result, "done");
  EXPECT_TRUE(test::mentions(ends[1].failure, {"2.5", "--max-seconds"}));
  EXPECT_EQ(ends[2].result, "done") << "the time of each job is its own";
}

TEST(RunJobs, NoMoreAtATimeThanAsked) {
  const test::TemporaryFolder folder;
  const auto most_of = [&](std::size_t count, std::size_t at_a_time) {
    const auto run = [&](std::size_t job, const JobProgress&) {
      const fs::path file = test::write_file(folder / std::to_string(job).c_str(), Bytes(1));
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      const auto now = std::distance(fs::directory_iterator(folder.path()), {});
      fs::remove(file);
      return std::to_string(now);
    };
    std::size_t most = 0;
    for (const JobEnd& end : run_all(count, at_a_time, run).ends) most = std::max<std::size_t>(most, std::stoul(end.result));
    return most;
  };
  EXPECT_EQ(most_of(5, 1), 1u);
  const std::size_t most_of_three = most_of(6, 3);
  EXPECT_GE(most_of_three, 2u) << "they did not run at the same time";
  EXPECT_LE(most_of_three, 3u);
}

/// A plant of a folder.
BatchPlant plant_in(const test::TemporaryFolder& folder, const std::string& name) {
  BatchPlant plant{folder / (name + ".glb").c_str(), folder / "out/deep" / (name + ".coppice"), {}};
  plant.options.view_count = 2;
  plant.options.collapse.resolution_px = 16;
  return plant;
}

TEST(BakeBatch, ResultsAreInTheOrderOfThePlants) {
  const test::TemporaryFolder folder;
  const std::vector<BatchPlant> plants{plant_in(folder, "a"), plant_in(folder, "b")};
  test::write_file(plants[0].input, Bytes(9000));  // not a plant, and the largest
  test::write_file(plants[1].input, test::small_plant().glb());
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
  BatchPlant plant = plant_in(folder, "oak");
  plant.all_variants = true;
  test::write_file(plant.input, test::small_plant().glb());
  ASSERT_EQ(expand_variants({plant}, {}).size(), 1u);
  EXPECT_EQ(expand_variants({plant}, {})[0].failure, "");
  constexpr std::size_t kMoreThanTheHeapHas = std::size_t{64} << 20;
  test::write_file(plant.input, Bytes(kMoreThanTheHeapHas));
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
  const fs::path root = folder / "plants", others = root / "folder.glb";
  fs::create_directories(others);
  for (const char* name : {"b.glb", "a/c.GLTF", "a/notes.txt", "a.b/d.gltf", "z.coppice"}) test::write_text(root / name, "any");
  const auto plants = plants_of_folder(root, "out", {});
  ASSERT_TRUE(plants) << plants.error().message();
  std::vector<std::pair<fs::path, fs::path>> found;
  for (const BatchPlant& plant : *plants) found.emplace_back(plant.input.lexically_relative(root), plant.output);
  EXPECT_EQ(found, (std::vector<std::pair<fs::path, fs::path>>{
                       {"a/c.GLTF", "out/a/c.coppice"}, {"a.b/d.gltf", "out/a.b/d.coppice"}, {"b.glb", "out/b.coppice"}}));
  EXPECT_TRUE(check_batch(*plants));
  EXPECT_FALSE(check_batch({{root / "b.glb", root / "a" / ".." / "b.glb", {}}})) << "an output over its input";
  EXPECT_FALSE(check_batch({{root / "b.glb", "list.json", {}}}, {"list.json"})) << "an output over the list";
  test::write_text(others / "pine.OBJ", "any");
  const auto other = plants_of_folder(others, "out", {});
  ASSERT_FALSE(other);
  EXPECT_TRUE(test::mentions(other.error().message(), {"wm.obj_import", "pine.OBJ"}));
}

TEST(BatchPlants, OutputsAreToldApartByWhereTheyAreAndKeepOutOfWhatIsKept) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  fs::create_directories(out / ".coppice-cluster");
  fs::create_directory_symlink(out / ".coppice-cluster", out / "runs");
  fs::create_directory_symlink(out, folder / "again");
  for (const char* name : {".coppice-cache/lock", ".coppice-cluster/x/run.json", "runs/x/run.json", "a/../.coppice-cache/x.coppice",
                           ".coppice-pictures/x.coppice", ".coppice-1-0.tmp"}) {
    const auto checked = check_batch({{folder / "a.glb", out / "a.coppice", {}}, {folder / "a.glb", out / name, {}, false, "[1]"}});
    ASSERT_FALSE(checked) << name;
    EXPECT_TRUE(test::mentions(checked.error().message(), {"[1].output", name}));
  }
  EXPECT_TRUE(check_batch({{folder / "a.glb", folder / ".coppice-mine" / "a.coppice", {}}}));
  const auto same = check_batch(
      {{folder / "a.glb", out / "x", {}, false, "[0]"}, {folder / "b.glb", folder / "again" / "b" / ".." / "x", {}, false, "[1]"}});
  ASSERT_FALSE(same);
  EXPECT_TRUE(test::mentions(same.error().message(), {"[0].output", "[1].output"}));
  // Links to nowhere are written through.
  fs::create_symlink("x", out / "to x");
  fs::create_symlink("to x", folder / "to it");
  EXPECT_FALSE(check_batch({{folder / "a.glb", out / "x", {}}, {folder / "b.glb", out / "to x", {}}}));
  EXPECT_TRUE(check_batch({{folder / "a.glb", out / "x", {}}, {folder / "b.glb", folder / "to it", {}}})) << "that is beside it";
  fs::create_directory_symlink(out / "new", folder / "to new");
  EXPECT_FALSE(check_batch({{folder / "a.glb", out / "new" / "x", {}}, {folder / "b.glb", folder / "to new" / "x", {}}}));
}

TEST(BatchPlants, NoOutputIsAFileThatAnInputRefersTo) {
  const test::TemporaryFolder folder;
  test::GltfBuilder builder = test::small_plant();
  builder.json["images"] = {{{"uri", "bark%20of%20oak.png"}}, {{"uri", "data:image/png;base64,AA=="}}};
  std::vector<BatchPlant> plants{{test::write_file(folder / "oak.glb", builder.glb()), folder / "oak.coppice", {}},
                                 {folder / "ash.glb", folder / "a" / ".." / "bark of oak.png", {}, false, "[1]"}};
  EXPECT_TRUE(check_batch(plants));
  plants.insert(plants.begin(), plants.front());
  plants.front().output = folder / "variant.coppice";
  estimate_inputs(plants);
  EXPECT_TRUE(plants[1].files.empty() && plants[1].cost == plants[0].cost) << "it was read for the one before";
  const auto checked = check_batch(plants);
  ASSERT_FALSE(checked);
  EXPECT_TRUE(test::mentions(checked.error().message(), {"overwritten", "oak.glb and [1].output", "bark of oak.png"}));
}

TEST(BatchPictures, WhatLinksElsewhereIsNoPictureAndIsDrawnAgain) {
  const test::TemporaryFolder folder;
  BatchPlant plant = plant_in(folder, "oak");
  test::write_file(plant.input, test::small_plant().glb());
  test::write_text(folder / "secret", "secret");
  fs::create_directory(folder / "pictures");
  fs::create_symlink(folder / "secret", folder / "pictures" / "KEY.webp");
  ASSERT_EQ(bake_cached(plant, folder / "cache", [](const char*, double) {}).outcome, BatchOutcome::baked);
  EXPECT_FALSE(read_picture(folder / "pictures", "KEY"));
  EXPECT_TRUE(draw_picture(plant.output, "KEY", folder / "pictures"));
  const auto drawn = read_picture(folder / "pictures", "KEY");
  ASSERT_TRUE(drawn) << drawn.error().message();
  // Whether there is one is told without reading it, which would take more memory than there is.
  fs::resize_file(folder / "pictures" / "KEY.webp", std::uintmax_t{1} << 41);
  EXPECT_TRUE(draw_picture(folder / "nowhere", "KEY", folder / "pictures"));
  EXPECT_GT(drawn->size(), 6u);
  EXPECT_EQ(test::read_text(folder / "secret"), "secret");
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
  Bytes output() { return *read_file(plant_.output); }

  test::TemporaryFolder folder_;
  fs::path cache_ = folder_ / "cache";
  BatchPlant plant_ = plant_in(folder_, "plant");
};

TEST_F(BakeCached, AnOlderStateIsFoundAgain) {
  const BatchResult first = bake();
  ASSERT_EQ(first.outcome, BatchOutcome::baked) << first.error;
  const Bytes first_bytes = output();
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
  const Bytes bytes = output();
  const auto expect_cached = [&] {
    EXPECT_EQ(bake().outcome, BatchOutcome::cached);
    EXPECT_EQ(output(), bytes);
  };
  test::write_file(plant_.output, Bytes(7));
  expect_cached();
  fs::remove(plant_.output);
  expect_cached();

  Bytes damaged = bytes;
  damaged[damaged.size() / 2] ^= 1;
  test::write_file(cache_ / (first.key + ".coppice"), damaged);
  const BatchResult mended = bake();
  EXPECT_EQ(mended.outcome, BatchOutcome::baked);
  ASSERT_EQ(mended.warnings.size(), first.warnings.size() + 1);
  EXPECT_NE(mended.warnings[0].find(first.key), std::string::npos) << mended.warnings[0];
  EXPECT_EQ(output(), bytes);
  expect_cached();
}

TEST_F(BakeCached, WhatFailsIsNotKeptAndLeavesTheOutput) {
  ASSERT_EQ(bake().outcome, BatchOutcome::baked);
  const Bytes bytes = output();
  test::write_file(plant_.input, Bytes(100));
  for (int i = 0; i < 2; ++i) {
    const BatchResult result = bake();
    EXPECT_EQ(result.outcome, BatchOutcome::failed);
    EXPECT_NE(result.error, "");
    EXPECT_EQ(output(), bytes);
  }
  fs::remove(plant_.input);
  EXPECT_EQ(bake().outcome, BatchOutcome::failed);
}

std::vector<PlantCost> costs_of(const std::vector<std::uint64_t>& seconds) {
  std::vector<PlantCost> costs;
  for (const std::uint64_t s : seconds) costs.push_back({1000 * s, 100'000'000});
  return costs;
}

std::uint64_t seconds_of(const PlantGroup& task, const std::vector<PlantCost>& costs) {
  return std::accumulate(task.begin(), task.end(), std::uint64_t{0},
                         [&](std::uint64_t sum, std::uint32_t plant) { return sum + costs[plant].milliseconds / 1000; });
}

/// How often each of so many plants is in a group.
std::vector<int> uses(const std::vector<PlantGroup>& groups, std::size_t count) {
  std::vector<int> times(count);
  for (const PlantGroup& group : groups)
    for (const std::uint32_t plant : group) ++times.at(plant);
  return times;
}

TEST(BatchPlan, TasksHoldEveryPlantOnceTheSlowestFirstAndBecomeShorter) {
  std::vector<std::uint64_t> seconds;
  for (std::uint64_t i = 0; i < 400; ++i) seconds.push_back(1 + i * 7919 % 60);
  const std::vector<PlantCost> costs = costs_of(seconds);
  const std::vector<PlantGroup> tasks = plan_tasks(costs, {.slots = 4});
  EXPECT_EQ(uses(tasks, 400), std::vector<int>(400, 1));
  EXPECT_EQ(costs[tasks[0][0]].milliseconds, 60'000u);
  for (std::size_t i = 1; i < tasks.size(); ++i) EXPECT_LE(seconds_of(tasks[i], costs), seconds_of(tasks[i - 1], costs) + 60) << i;
  EXPECT_GT(seconds_of(tasks.front(), costs), 240u) << "minutes";
  EXPECT_LE(seconds_of(tasks.front(), costs), 300u);
  EXPECT_LE(seconds_of(tasks.back(), costs), 10u) << "all slots end at about the same time";
}

TEST(BatchPlan, ThereAreNoMoreTasksThanSlurmTakes) {
  const std::vector<PlantGroup> tasks = plan_tasks(costs_of(std::vector<std::uint64_t>(10'000, 200)), {.slots = 2000});
  EXPECT_LE(tasks.size(), 1000u);
  EXPECT_EQ(uses(tasks, 10'000), std::vector<int>(10'000, 1));
  EXPECT_TRUE(plan_tasks({}, {.slots = 2000}).empty());
}

TEST(BatchPlan, TwoThousandPlantsKeepFourNodesBusy) {
  // Estimates are wrong by up to a factor of two either way.
  std::vector<std::uint64_t> estimates, seconds;
  for (std::uint64_t i = 0; i < 2'000; ++i) {
    const std::uint64_t estimate = 15 + i * 7919 % 40;
    estimates.push_back(estimate);
    seconds.push_back(i * 104'729 % 2 == 0 ? estimate / 2 + i % 10 : 2 * estimate - i % 10);
  }
  const std::vector<PlantCost> costs = costs_of(estimates), real = costs_of(seconds);
  // As schedulers do, each task goes to the slot that is free first, and takes a second to start.
  std::vector<std::uint64_t> busy_s(4 * 16);
  for (const PlantGroup& task : plan_tasks(costs, {.slots = 4 * 16})) *std::ranges::min_element(busy_s) += 1 + seconds_of(task, real);
  // Against one node of sixteen processors that never waits.
  const auto all_s = static_cast<double>(std::accumulate(seconds.begin(), seconds.end(), std::uint64_t{0}));
  EXPECT_GE(all_s / 16.0 / static_cast<double>(std::ranges::max(busy_s)), 3.6) << std::ranges::max(busy_s) << " s";
}

TEST(BatchPlan, ShardsTakeAboutEquallyLong) {
  const std::vector<PlantCost> costs = costs_of({60, 1, 1, 30, 30, 2, 2, 50, 4});
  const auto shards = plan_shards(costs, 3);
  ASSERT_EQ(shards.size(), 3u);
  for (const auto& shard : shards) {
    EXPECT_NEAR(static_cast<double>(seconds_of(shard, costs)), 60.0, 4.0);
    EXPECT_TRUE(std::ranges::is_sorted(shard));
  }
  EXPECT_EQ(uses(shards, 9), std::vector<int>(9, 1));
  EXPECT_EQ(plan_shards(costs, 100).size(), 100u);
}

TEST(PlantCost, ViewsAndTrianglesCount) {
  const test::TemporaryFolder folder;
  const fs::path path = test::write_file(folder / "small.glb", test::small_plant().glb());
  const InputCounts counts = count_input(path, {});
  EXPECT_GT(counts.triangles, 0u);
  EXPECT_EQ(counts.bytes, fs::file_size(path));
  BakeOptions fewer;
  fewer.view_count = 2;
  EXPECT_LT(plant_cost(counts, fewer).milliseconds, plant_cost(counts, {}).milliseconds);
  EXPECT_LT(plant_cost(counts, {}).milliseconds, plant_cost({counts.triangles + 1'000'000, counts.bytes}, {}).milliseconds);
  // What is no plant costs something all the same.
  test::write_text(folder / "letter.glb", "a letter");
  EXPECT_EQ(count_input(folder / "letter.glb", {}).triangles, 0u);
  EXPECT_EQ(count_input(folder / "nowhere.glb", {}).bytes, 0u);
}

TEST(PlantCost, IsWhatABakeWouldRead) {
  const test::TemporaryFolder folder;
  test::GltfBuilder builder = test::small_plant();  // three triangles
  const auto triangles = [&](const ImportOptions& options = {}) {
    return count_input(test::write_file(folder / "plant.glb", builder.glb()), options).triangles;
  };
  EXPECT_EQ(triangles(), 3u);
  builder.add_node(0);
  EXPECT_EQ(triangles(), 5u);
  EXPECT_EQ(triangles({.max_source_triangles = 4}), 0u) << "it is refused";
  // One product of nodes and primitives that are nothing at all.
  for (int i = 0; i < 50000; ++i) {
    builder.json["meshes"][1]["primitives"].push_back({{"attributes", nlohmann::json::object()}, {"mode", 0}});
    builder.add_node(1);
  }
  EXPECT_EQ(triangles(), 0u);
}

TEST(Slurm, WhatSqueuePrintsIsReadAndOtherLinesAreSkipped) {
  const JobState job = parse_job_state(
      "3|RUNNING|None\n4|PENDING|JobHeldUser\n5|OUT_OF_MEMORY|None\n6|COMPLETING|None\nN/A|RUNNING|None\nslurm_load_jobs error: no\n");
  EXPECT_EQ(job.running, 2u);
  EXPECT_EQ(job.pending, 1u);
  EXPECT_EQ(job.reason, "JobHeldUser");
  EXPECT_EQ(job.ended, (std::map<std::uint32_t, std::string>{{5, "OUT_OF_MEMORY"}}));
  EXPECT_FALSE(parse_job_state("1|COMPLETED|None\n").is_live());
}

TEST(Slurm, OptionsThatWouldHideTheTasksAreRefused) {
  for (const char* const option : {"-M", "--clusters=all", "--wrap=true", "-W", "--wait"})
    EXPECT_FALSE(refused_sbatch_option({"-p", "long", option}).empty()) << option;
  EXPECT_EQ(refused_sbatch_option({"-A", "project", "--account=x", "-m", "--wait-all-nodes=1"}), "");
  for (const char* const option : {"--mem=4G", "--mem", "--mem-per-cpu=1G", "--mem-per-gpu=1G"})
    EXPECT_TRUE(chooses_memory({"-p", "long", option})) << option;
  EXPECT_FALSE(chooses_memory({"--mem-bind=local", "--memo"}));
}

TEST(Slurm, ProcessorsOfATaskAreThoseOfTheLastOption) {
  const std::vector<std::pair<std::vector<std::string>, std::uint32_t>> cases{{{}, 1},
                                                                              {{"-p", "long", "--cores-per-socket=8", "-C", "9"}, 1},
                                                                              {{"-c", "4"}, 4},
                                                                              {{"-c4"}, 4},
                                                                              {{"--cpus-per-task", "4"}, 4},
                                                                              {{"--cpus-per-task=4"}, 4},
                                                                              {{"-c2", "-c", "3", "--cpus-per-task=6"}, 6},
                                                                              {{"-c", "0"}, 1}};
  for (const auto& [options, processors] : cases) EXPECT_EQ(processors_of_task(options), processors) << testing::PrintToString(options);
}

TEST(Slurm, WordsComeThroughAShellAsTheyWere) {
  const std::vector<std::string> words{"printf", "%s|", "cop'pice", "$HOME `x`", "", "100% of \"it\""};
  EXPECT_EQ(test::run_process("/bin/sh", {"-c", shell_command(words)}).out, "cop'pice|$HOME `x`||100% of \"it\"|");
}

TEST(PlantRecord, AJournalsEntryComesBackAsItWas) {
  const test::TemporaryFolder folder;
  const BatchPlant plant{"/in/oak.glb", "/out/oak.coppice", {}};
  const BatchResult baked{.outcome = BatchOutcome::baked, .file_bytes = 1u << 20, .warnings = {"a \"warning\""}};
  auto journal = Journal::open(folder / "journal.jsonl");
  ASSERT_TRUE(journal && journal->add(plant, baked));
  std::string line = test::read_text(folder / "journal.jsonl");
  ASSERT_EQ(line.back(), '\n');
  line.pop_back();
  const auto entry = journal_entry(line);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->output, "/out/oak.coppice");
  EXPECT_EQ(entry->result.outcome, BatchOutcome::baked);
  EXPECT_EQ(entry->result.file_bytes, baked.file_bytes);
  EXPECT_EQ(entry->result.warnings, baked.warnings);
  for (std::size_t end = 0; end < line.size(); ++end) EXPECT_FALSE(journal_entry(line.substr(0, end))) << end;
  fs::create_hard_link(folder / "journal.jsonl", folder / "other name");
  test::expect_error(Journal::open(folder / "other name"), Status::io, {"other name", "several names", "name another file"});
  test::expect_error(Journal::open("/dev/full"), Status::io, {"/dev/full", "not a plain file"});
  auto nowhere = Journal::open("/dev/null");
  EXPECT_TRUE(nowhere && nowhere->add(plant, baked));
  EXPECT_TRUE(journal_entry(journal_line(plant, {.error = "ended by a signal: Killed", .lost = true}))->result.lost);
}

/// As network file systems do that give what everybody writes to a user of their own.
TEST(PlantRecord, AJournalIsOursWhereNewFilesBelongToItsOwner) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can act for another user";
  constexpr uid_t kOther = 4711;
  const test::TemporaryFolder folder;
  const fs::path path = folder / "journal.jsonl";
  test::write_text(path, "");
  fs::permissions(folder.path(), fs::perms::all);
  ASSERT_EQ(::chown(path.c_str(), kOther, kOther), 0);
  test::expect_error(Journal::open(path), Status::io, {"journal.jsonl", "another user", "name another file"});
  ::setfsuid(kOther);
  const auto journal = Journal::open(path);
  ::setfsuid(::geteuid());
  EXPECT_TRUE(journal) << journal.error().message();
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

}  // namespace coppice::bake::batch_test
