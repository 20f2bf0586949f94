// How plants are dealt out to tasks, shards and lists.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bake_key.h"
#include "batch_manifest.h"
#include "farm_follow.h"
#include "farm_plan.h"
#include "farm_run.h"
#include "farm_tries.h"
#include "gltf_builder.h"
#include "plant_record.h"
#include "process.h"
#include "sbatch_options.h"
#include "slurm.h"

namespace coppice::bake {
namespace farm_plan_test {

namespace fs = std::filesystem;

std::vector<PlantCost> costs_of(const std::vector<std::uint64_t>& seconds, std::uint64_t memory_bytes = 100'000'000) {
  std::vector<PlantCost> costs;
  for (const std::uint64_t s : seconds) costs.push_back({1000 * s, memory_bytes});
  return costs;
}

std::uint64_t seconds_of(const FarmTask& task, const std::vector<PlantCost>& costs) {
  return std::accumulate(task.plants.begin(), task.plants.end(), std::uint64_t{0},
                         [&](std::uint64_t sum, std::uint32_t plant) { return sum + costs[plant].milliseconds / 1000; });
}

std::vector<std::uint32_t> all_plants(const std::vector<FarmArray>& arrays) {
  std::vector<std::uint32_t> plants;
  for (const FarmArray& array : arrays)
    for (const FarmTask& task : array.tasks) plants.insert(plants.end(), task.plants.begin(), task.plants.end());
  std::ranges::sort(plants);
  return plants;
}

std::vector<std::uint32_t> first_numbers(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

TEST(FarmPlan, TasksHoldEveryPlantOnceTheSlowestFirstAndBecomeShorter) {
  std::vector<std::uint64_t> seconds;
  for (std::uint64_t i = 0; i < 400; ++i) seconds.push_back(1 + i * 7919 % 60);
  const std::vector<PlantCost> costs = costs_of(seconds);
  PlanOptions options;
  options.slots = 4;
  const std::vector<FarmArray> arrays = plan_arrays(costs, options);
  ASSERT_EQ(arrays.size(), 1u);
  EXPECT_EQ(all_plants(arrays), first_numbers(400));
  const std::vector<FarmTask>& tasks = arrays[0].tasks;
  EXPECT_EQ(costs[tasks[0].plants[0]].milliseconds, 60'000u);
  for (std::size_t i = 1; i < tasks.size(); ++i) EXPECT_LE(seconds_of(tasks[i], costs), seconds_of(tasks[i - 1], costs) + 60) << i;
  EXPECT_GT(seconds_of(tasks.front(), costs), 240u) << "minutes";
  EXPECT_LE(seconds_of(tasks.front(), costs), 300u);
  EXPECT_LE(seconds_of(tasks.back(), costs), 10u) << "all slots end at about the same time";
}

TEST(FarmPlan, OneArrayHasOneLimitOfMemory) {
  std::vector<PlantCost> costs = costs_of({5, 5, 5, 5}, 100'000'000);
  costs[2].memory_bytes = 3'000'000'000;
  const std::vector<FarmArray> arrays = plan_arrays(costs, {});
  ASSERT_EQ(arrays.size(), 2u);
  EXPECT_EQ(arrays[0].tasks[0].plants, std::vector<std::uint32_t>{2});
  EXPECT_GE(arrays[0].memory_bytes, 4'500'000'000u) << "half as much again";
  EXPECT_EQ(arrays[1].memory_bytes, 512'000'000u);
  EXPECT_EQ(arrays[1].minutes, 10u) << "and four times the 10 s of a task";
  PlanOptions one;
  one.arrays = FarmArrays::one;
  EXPECT_EQ(plan_arrays(costs, one).size(), 1u);
  EXPECT_TRUE(plan_arrays({}, {}).empty());
}

TEST(FarmPlan, ThereAreNoMoreTasksThanSlurmTakes) {
  const std::vector<PlantCost> costs = costs_of(std::vector<std::uint64_t>(10'000, 200));
  PlanOptions options;
  options.slots = 2000;
  const std::vector<FarmArray> arrays = plan_arrays(costs, options);
  std::size_t tasks = 0;
  for (const FarmArray& array : arrays) {
    EXPECT_LE(array.tasks.size(), 1000u);
    tasks += array.tasks.size();
  }
  EXPECT_LE(tasks, 4000u);
  EXPECT_EQ(all_plants(arrays), first_numbers(10'000));
  options.arrays = FarmArrays::one;
  EXPECT_EQ(plan_arrays(costs, options).size(), 1u);
}

/// List scheduling: each task goes to the slot that is free first, as schedulers do.
std::uint64_t seconds_on(std::size_t slots, const std::vector<FarmArray>& arrays, const std::vector<PlantCost>& real,
                         std::uint64_t start_s) {
  std::vector<std::uint64_t> busy_s(slots, 0);
  for (const FarmArray& array : arrays)
    for (const FarmTask& task : array.tasks) *std::ranges::min_element(busy_s) += start_s + seconds_of(task, real);
  return std::ranges::max(busy_s);
}

TEST(FarmPlan, TenThousandPlantsKeepSixteenNodesBusy) {
  // Estimates are wrong by up to a factor of two either way; a task takes a second to start.
  std::vector<std::uint64_t> estimates, seconds;
  for (std::uint64_t i = 0; i < 10'000; ++i) {
    const std::uint64_t estimate = 15 + i * 7919 % 40;
    estimates.push_back(estimate);
    seconds.push_back(i * 104'729 % 2 == 0 ? estimate / 2 + i % 10 : 2 * estimate - i % 10);
  }
  const std::vector<PlantCost> costs = costs_of(estimates), real = costs_of(seconds);
  PlanOptions options;
  options.slots = 16 * 16;
  const std::uint64_t all_s = std::accumulate(seconds.begin(), seconds.end(), std::uint64_t{0});
  const std::uint64_t taken_s = seconds_on(options.slots, plan_arrays(costs, options), real, 1);
  // Against one node of sixteen processors that never waits.
  EXPECT_GE(static_cast<double>(all_s) / 16.0 / static_cast<double>(taken_s), 14.4) << taken_s << " s";
}

TEST(FarmPlan, ShardsTakeAboutEquallyLong) {
  const std::vector<PlantCost> costs = costs_of({60, 1, 1, 30, 30, 2, 2, 50, 4});
  const auto shards = plan_shards(costs, 3);
  ASSERT_EQ(shards.size(), 3u);
  std::vector<std::uint32_t> all;
  for (const auto& shard : shards) {
    EXPECT_NEAR(static_cast<double>(seconds_of({shard}, costs)), 60.0, 4.0);
    EXPECT_TRUE(std::ranges::is_sorted(shard));
    all.insert(all.end(), shard.begin(), shard.end());
  }
  std::ranges::sort(all);
  EXPECT_EQ(all, first_numbers(9));
  EXPECT_EQ(plan_shards(costs, 100).size(), 100u);
}

TEST(PlantCost, ViewsAndTrianglesCount) {
  const test::TemporaryFolder folder;
  const fs::path path = folder / "small.glb";
  test::write_file(path, test::small_plant().glb());
  const InputCounts counts = count_input(path, {});
  EXPECT_GT(counts.triangles, 0u);
  EXPECT_EQ(counts.bytes, fs::file_size(path));
  BakeOptions fewer;
  fewer.view_count = 2;
  EXPECT_LT(plant_cost(counts, fewer).milliseconds, plant_cost(counts, {}).milliseconds);
  EXPECT_LT(plant_cost(counts, {}).milliseconds, plant_cost({counts.triangles + 1'000'000, counts.bytes}, {}).milliseconds);
  // What is no plant costs something all the same.
  std::ofstream(folder / "letter.glb") << "a letter";
  EXPECT_EQ(count_input(folder / "letter.glb", {}).triangles, 0u);
  EXPECT_EQ(count_input(folder / "nowhere.glb", {}).bytes, 0u);
}

TEST(PlantCost, InstancesCountAndWhatIsDamagedDoesNotOverflow) {
  const test::TemporaryFolder folder;
  const auto triangles = [&](const std::string& nodes, const std::string& first_count) {
    const fs::path path = folder / "plant.gltf";
    std::ofstream(path) << R"({"accessors": [{"count": )" + first_count + R"(}, {"count": 15}], "nodes": )" + nodes +
                               R"(, "meshes": [{"primitives": [{"indices": 0}, {"indices": 1}, {"mode": 1, "indices": 0}]}]})";
    return count_input(path, {}).triangles;
  };
  EXPECT_EQ(triangles(R"([{"mesh": 0}])", "30"), 15u);
  const std::string instanced = R"({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}})";
  EXPECT_EQ(triangles(R"([{"mesh": 0}, )" + instanced + "]", "30"), 16u * 15);
  const std::uint64_t most = triangles("[" + instanced + ", " + instanced + "]", "18446744073709551615");
  EXPECT_GT(most, std::uint64_t{1} << 38);
  EXPECT_LE(most, std::uint64_t{1} << 40);
}

TEST(Manifest, AnEntrySaysEverythingOfAPlant) {
  const test::TemporaryFolder folder;
  const fs::path input = folder / "small.glb", list = folder / "list.json", classes = folder / "classes.json", out = folder / "out";
  test::write_file(input, test::small_plant().glb());
  BakeOptions all;
  all.metric = Metric::geometric;
  all.view_count = 7;
  all.import.leaf_material = "^le\"a[f]$";
  all.import.wood_material = "wood";
  all.import.classes = {{"^x$", PlantPart::dropped, 3, 9, {}}, {"y", PlantPart::wood, 0, 5, {}}};
  all.import.up = UpAxis::z;
  all.import.metres_per_unit = 0.0254;
  all.import.wind_color_set = 2;
  all.import.plant = {"oak", 3, false};
  all.import.outside_files = OutsideFiles::allowed;
  all.collapse.resolution_px = 99;
  all.collapse.count_background = false;
  all.collapse.candidate_count = 5;
  all.textures = TextureCoding::rgba8;
  all.crown_normals = 0.3f;
  all.leaf_meshes = false;
  all.wind = {false, 1.7f};
  BakeOptions whole;
  whole.import.plant.whole = true;
  BakeOptions measured;
  measured.metric = Metric::mi;
  for (const BakeOptions& options : {BakeOptions(), all, whole, measured}) {
    const auto entry = manifest_entry({input, out / "a/b.coppice", options}, out, classes);
    ASSERT_TRUE(entry);
    std::ofstream(list) << "[" << *entry << "]";
    std::ofstream(classes) << classes_text(options.import.classes);
    const auto plants = plants_of_manifest(list, out, {});
    ASSERT_TRUE(plants) << plants.error().message();
    const BatchPlant& plant = (*plants)[0];
    EXPECT_EQ(plant.input, input);
    EXPECT_EQ(plant.output, out / "a/b.coppice");
    EXPECT_EQ(plant.options.import.outside_files, options.import.outside_files);
    EXPECT_EQ(*bake_key(plant.input, plant.options), *bake_key(input, options));
  }
}

TEST(FarmRun, ComesBackFromItsFilesAsItWas) {
  const test::TemporaryFolder folder;
  const auto run_folder = make_run_folder(folder.path());
  ASSERT_TRUE(run_folder);
  EXPECT_FALSE(newest_run(folder.path())) << "nothing is in it yet";
  const test::TemporaryFolder other;  // in the same second, as from a script
  EXPECT_NE(make_run_folder(other.path())->filename(), run_folder->filename());
  FarmRun run;
  run.folder = *run_folder;
  run.output_folder = folder.path();
  run.coppice = "/opt/cop'pice";
  run.sbatch_options = {"-c", "4"};
  run.task_options = {"--quiet"};
  run.plants = {{"/a.glb", "/out/a.coppice", R"({"input": "/a.glb"})", {5, 6}, {}}, {"/b.glb", "/out/b.coppice", "{}", {7, 8}, "not read"}};
  run.cache.where = "https://cache.example";
  run.cache.unasked = 2;
  run.cache.lost_seconds = 1.5;
  Submission submission;
  submission.memory_bytes = 512'000'000;
  submission.minutes = 12;
  submission.tasks = {{{0}}};
  ASSERT_TRUE(write_submission(run, submission));
  ASSERT_TRUE(write_run(run));
  EXPECT_EQ(*newest_run(folder.path()), *run_folder);
  const auto read = read_run(*run_folder);
  ASSERT_TRUE(read) << read.error().message();
  EXPECT_EQ(read->plants[1].failure, "not read");
  EXPECT_EQ(read->plants[0].cost, run.plants[0].cost);
  EXPECT_EQ(read->sbatch_options, run.sbatch_options);
  EXPECT_EQ(read->cache.where, run.cache.where);
  EXPECT_EQ(read->cache.unasked, 2u);
  EXPECT_EQ(read->cache.lost_seconds, 1.5);
  const auto submissions = read_submissions(*read);
  ASSERT_TRUE(submissions);
  ASSERT_EQ(submissions->size(), 1u);
  EXPECT_EQ((*submissions)[0].tasks[0].plants, std::vector<std::uint32_t>{0});
  const std::string script = script_text(run, submission);
  EXPECT_NE(script.find("#SBATCH --mem=2049M\n"), std::string::npos) << script;  // of four processors
  EXPECT_NE(script.find(R"(coppice='/opt/cop'\''pice')"), std::string::npos) << script;
  {
    const auto lock = RunLock::take(*run_folder);
    EXPECT_TRUE(lock);
    EXPECT_FALSE(RunLock::take(*run_folder));
  }
  EXPECT_TRUE(RunLock::take(*run_folder));
}

TEST(SbatchOptions, SayHowManyProcessorsATaskGets) {
  EXPECT_EQ(processors_of_task({}), 1u);
  EXPECT_EQ(processors_of_task({"-p", "long", "-c", "8"}), 8u);
  EXPECT_EQ(processors_of_task({"-c16"}), 16u);
  EXPECT_EQ(processors_of_task({"--cpus-per-task=2", "--mem=0"}), 2u);
  EXPECT_EQ(processors_of_task({"--cpus-per-task", "3"}), 3u);
  EXPECT_EQ(processors_of_task({"-c", "2", "-c", "5"}), 5u) << "the last counts";
  EXPECT_EQ(processors_of_task({"-c", "8", "--cpus-per-task=2"}), 2u) << "whichever of its names it has";
  EXPECT_EQ(processors_of_task({"-C", "haswell", "--constraint", "x", "-c"}), 1u);
}

TEST(SbatchOptions, SayHowMuchMemoryATaskGets) {
  for (const char* const option : {"--mem=4G", "--mem-per-cpu=1G", "--mem-per-gpu=1G"}) EXPECT_TRUE(say_memory({"-p", "long", option}));
  EXPECT_TRUE(say_memory({"--mem", "4G"}));
  EXPECT_FALSE(say_memory({"--mem-bind=local", "--memo"}));
}

TEST(SbatchOptions, OfTheTasksNameArrayAndClusterAreReserved) {
  for (const char* const option :
       {"-J", "-Jname", "--job-name=name", "--array", "-a1", "-M", "--clusters=all", "--wrap=true", "-W", "--wait"})
    EXPECT_FALSE(reserved_option({"-p", "long", option}).empty()) << option;
  EXPECT_EQ(reserved_option({"-A", "project", "--account=x", "-m", "--array-inx", "--wait-all-nodes=1"}), "");
}

TEST(Slurm, LinesOfTheQueueAreReadAndOthersLeftAlone) {
  FarmRun run;
  run.folder = "/out/.coppice-farm/20261126-220000-00";
  Queue queue;
  EXPECT_TRUE(read_queue_line("12|3|RUNNING|node1|coppice-20261126-220000-00-2|None", run, queue));
  EXPECT_TRUE(read_queue_line("12|4|NODE_FAIL||coppice-20261126-220000-00-2|None", run, queue));
  EXPECT_FALSE(read_queue_line("12|3|RUNNING|node1|coppice-other-2|None", run, queue));
  EXPECT_FALSE(read_queue_line("12|N/A|RUNNING|node1|coppice-20261126-220000-00-2|None", run, queue));
  EXPECT_FALSE(read_queue_line("slurm_load_jobs error: no", run, queue));
  ASSERT_EQ(queue.size(), 2u);
  EXPECT_TRUE(queue.at({2, 3}).is_live && queue.at({2, 3}).runs);
  EXPECT_EQ(queue.at({2, 3}).job, "12");
  EXPECT_FALSE(queue.at({2, 4}).is_live);
  // Of two tasks of one number the one that lives counts, whichever comes first.
  EXPECT_TRUE(read_queue_line("13|4|PENDING||coppice-20261126-220000-00-2|JobHeldUser", run, queue));
  EXPECT_TRUE(read_queue_line("12|4|NODE_FAIL||coppice-20261126-220000-00-2|None", run, queue));
  EXPECT_TRUE(queue.at({2, 4}).is_live);
  EXPECT_EQ(queue.at({2, 4}).reason, "JobHeldUser");
}

TEST(PlantRecord, AJournalsEntryComesBackAsItWas) {
  const test::TemporaryFolder folder;
  const fs::path path = folder / "journal.jsonl";
  const BatchPlant plant{"/in/oak.glb", "/out/oak.coppice", {}};
  BatchResult baked;
  baked.outcome = BatchOutcome::baked;
  baked.key = "0123";
  baked.source_leaves = 7;
  baked.file_bytes = 1u << 20;
  baked.foliage_bytes = 99;
  baked.seconds = 1.5;
  baked.peak_rss_bytes = 12345;
  baked.warnings = {"a \"warning\""};
  {
    auto journal = Journal::open(path);
    ASSERT_TRUE(journal);
    ASSERT_TRUE(journal->add(plant, baked));
  }
  std::ifstream file(path);
  std::string line;
  ASSERT_TRUE(std::getline(file, line));
  const auto entry = journal_entry(line);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->output, "/out/oak.coppice");
  EXPECT_EQ(entry->result.outcome, BatchOutcome::baked);
  EXPECT_EQ(entry->result.file_bytes, baked.file_bytes);
  EXPECT_EQ(entry->result.warnings, baked.warnings);
  for (std::size_t end = 0; end < line.size(); ++end) EXPECT_FALSE(journal_entry(line.substr(0, end))) << end;
}

TEST(FarmTries, TheJournalOfATaskThatHasEndedIsReadToItsEndEvenLate) {
  const test::TemporaryFolder folder;
  const fs::path tries_folder = folder / "tries", stem = tries_folder / "001-0000.7.node1.42";
  fs::create_directory(tries_folder);
  const auto file = [&](const char* extension) { return fs::path(stem.string() + extension); };
  std::ofstream(file(".start")) << R"({"node": "node1", "job": "7", "array_job": "7", "restart": 0, "time": 10.5})"
                                << "\n";
  BatchResult baked;
  baked.outcome = BatchOutcome::baked;
  const std::string lines = journal_line({"a.glb", "a.coppice", {}}, baked) + journal_line({"b.glb", "b.coppice", {}}, baked);
  const std::size_t half = lines.size() - 5;
  std::ofstream(file(".plants")) << lines.substr(0, half);
  Tries tries;
  EXPECT_EQ(read_tries(folder.path(), tries).size(), 1u) << "the second line is not whole";
  // The end is known before the journal can be read again, as over a network.
  std::ofstream(file(".end")) << R"({"exit": 0, "time": 12.0})"
                              << "\n";
  fs::rename(file(".plants"), folder / "elsewhere");
  fs::create_symlink(folder / "nowhere", file(".plants"));
  EXPECT_TRUE(read_tries(folder.path(), tries).empty());
  fs::remove(file(".plants"));
  fs::rename(folder / "elsewhere", file(".plants"));
  std::ofstream(file(".plants"), std::ios::app) << lines.substr(half);
  const std::vector<TriedPlant> rest = read_tries(folder.path(), tries);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest.front().entry.output, "b.coppice");
  EXPECT_EQ(tries.begin()->second.exit_code, 0);
  EXPECT_TRUE(read_tries(folder.path(), tries).empty());
}

TEST(PlantRecord, WhatWasTakenAwayIsNoFaultOfThePlant) {
  BatchResult result;
  for (const char* error :
       {"ended by a signal: Killed", "ended by a signal: Terminated", "out of memory", "no process: Resource temporarily unavailable"}) {
    result.error = error;
    EXPECT_TRUE(was_taken_away(result)) << error;
  }
  for (const char* error :
       {"ended by a signal: Segmentation fault", "not glTF", "out of memory: it needs more than the 5 MB of --max-memory-mb; raise that"}) {
    result.error = error;
    EXPECT_FALSE(was_taken_away(result)) << error;
  }
  result.outcome = BatchOutcome::baked;
  result.error = "out of memory";
  EXPECT_FALSE(was_taken_away(result));
}

}  // namespace farm_plan_test
}  // namespace coppice::bake
