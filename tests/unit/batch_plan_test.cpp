// Plans of tasks and shards, costs, list entries, journals, and the text that Slurm gets and prints.

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bake_key.h"
#include "batch_manifest.h"
#include "gltf_builder.h"
#include "plant_cost.h"
#include "plant_record.h"
#include "process.h"
#include "slurm.h"

namespace coppice::bake {
namespace batch_plan_test {

namespace fs = std::filesystem;

std::vector<PlantCost> costs_of(const std::vector<std::uint64_t>& seconds) {
  std::vector<PlantCost> costs;
  for (const std::uint64_t s : seconds) costs.push_back({1000 * s, 100'000'000});
  return costs;
}

std::uint64_t seconds_of(const PlantGroup& task, const std::vector<PlantCost>& costs) {
  return std::accumulate(task.begin(), task.end(), std::uint64_t{0},
                         [&](std::uint64_t sum, std::uint32_t plant) { return sum + costs[plant].milliseconds / 1000; });
}

std::vector<std::uint32_t> all_plants(const std::vector<PlantGroup>& groups) {
  std::vector<std::uint32_t> plants;
  for (const PlantGroup& group : groups) plants.insert(plants.end(), group.begin(), group.end());
  std::ranges::sort(plants);
  return plants;
}

std::vector<std::uint32_t> first_numbers(std::size_t count) {
  std::vector<std::uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  return numbers;
}

TEST(BatchPlan, TasksHoldEveryPlantOnceTheSlowestFirstAndBecomeShorter) {
  std::vector<std::uint64_t> seconds;
  for (std::uint64_t i = 0; i < 400; ++i) seconds.push_back(1 + i * 7919 % 60);
  const std::vector<PlantCost> costs = costs_of(seconds);
  TaskPlan plan;
  plan.slots = 4;
  const std::vector<PlantGroup> tasks = plan_tasks(costs, plan);
  EXPECT_EQ(all_plants(tasks), first_numbers(400));
  EXPECT_EQ(costs[tasks[0][0]].milliseconds, 60'000u);
  for (std::size_t i = 1; i < tasks.size(); ++i) EXPECT_LE(seconds_of(tasks[i], costs), seconds_of(tasks[i - 1], costs) + 60) << i;
  EXPECT_GT(seconds_of(tasks.front(), costs), 240u) << "minutes";
  EXPECT_LE(seconds_of(tasks.front(), costs), 300u);
  EXPECT_LE(seconds_of(tasks.back(), costs), 10u) << "all slots end at about the same time";
}

TEST(BatchPlan, ThereAreNoMoreTasksThanSlurmTakes) {
  const std::vector<PlantCost> costs = costs_of(std::vector<std::uint64_t>(10'000, 200));
  TaskPlan plan;
  plan.slots = 2000;
  const std::vector<PlantGroup> tasks = plan_tasks(costs, plan);
  EXPECT_LE(tasks.size(), 1000u);
  EXPECT_EQ(all_plants(tasks), first_numbers(10'000));
  EXPECT_TRUE(plan_tasks({}, plan).empty());
}

/// List scheduling: each task goes to the slot that is free first, as schedulers do.
std::uint64_t seconds_on(std::size_t slots, const std::vector<PlantGroup>& tasks, const std::vector<PlantCost>& real,
                         std::uint64_t start_s) {
  std::vector<std::uint64_t> busy_s(slots, 0);
  for (const PlantGroup& task : tasks) *std::ranges::min_element(busy_s) += start_s + seconds_of(task, real);
  return std::ranges::max(busy_s);
}

TEST(BatchPlan, TwoThousandPlantsKeepFourNodesBusy) {
  // Estimates are wrong by up to a factor of two either way; a task takes a second to start.
  std::vector<std::uint64_t> estimates, seconds;
  for (std::uint64_t i = 0; i < 2'000; ++i) {
    const std::uint64_t estimate = 15 + i * 7919 % 40;
    estimates.push_back(estimate);
    seconds.push_back(i * 104'729 % 2 == 0 ? estimate / 2 + i % 10 : 2 * estimate - i % 10);
  }
  const std::vector<PlantCost> costs = costs_of(estimates), real = costs_of(seconds);
  TaskPlan plan;
  plan.slots = 4 * 16;
  const std::uint64_t all_s = std::accumulate(seconds.begin(), seconds.end(), std::uint64_t{0});
  const std::uint64_t taken_s = seconds_on(plan.slots, plan_tasks(costs, plan), real, 1);
  // Against one node of sixteen processors that never waits.
  EXPECT_GE(static_cast<double>(all_s) / 16.0 / static_cast<double>(taken_s), 3.6) << taken_s << " s";
}

TEST(BatchPlan, ShardsTakeAboutEquallyLong) {
  const std::vector<PlantCost> costs = costs_of({60, 1, 1, 30, 30, 2, 2, 50, 4});
  const auto shards = plan_shards(costs, 3);
  ASSERT_EQ(shards.size(), 3u);
  for (const auto& shard : shards) {
    EXPECT_NEAR(static_cast<double>(seconds_of(shard, costs)), 60.0, 4.0);
    EXPECT_TRUE(std::ranges::is_sorted(shard));
  }
  EXPECT_EQ(all_plants(shards), first_numbers(9));
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
  const fs::path input = folder / "small.glb", list = folder / "list.json", out = folder / "out";
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
    const auto entry = manifest_entry({input, out / "a/b.coppice", options}, out);
    ASSERT_TRUE(entry);
    std::ofstream(list) << "[" << *entry << "]";
    const auto plants = plants_of_manifest(list, out, {});
    ASSERT_TRUE(plants) << plants.error().message();
    const BatchPlant& plant = (*plants)[0];
    EXPECT_EQ(plant.input, input);
    EXPECT_EQ(plant.output, out / "a/b.coppice");
    EXPECT_EQ(plant.options.import.outside_files, options.import.outside_files);
    EXPECT_EQ(*bake_key(plant.input, plant.options), *bake_key(input, options));
  }
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
  EXPECT_EQ(processors_of_task({}), 1u);
  EXPECT_EQ(processors_of_task({"-p", "long", "--cores-per-socket=8", "-C", "9"}), 1u);
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"-c", "4"}, {"-c4"}, {"--cpus-per-task", "4"}, {"--cpus-per-task=4"}})
    EXPECT_EQ(processors_of_task(options), 4u) << options.front();
  EXPECT_EQ(processors_of_task({"-c2", "-c", "3", "--cpus-per-task=6"}), 6u);
  EXPECT_EQ(processors_of_task({"-c", "0"}), 1u);
}

TEST(Slurm, WordsComeThroughAShellAsTheyWere) {
  const std::vector<std::string> words{"printf", "%s|", "cop'pice", "$HOME `x`", "", "100% of \"it\""};
  EXPECT_EQ(test::run_process("/bin/sh", {"-c", shell_command(words)}).out, "cop'pice|$HOME `x`||100% of \"it\"|");
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
  BatchResult failed;
  failed.error = "ended by a signal: Killed";
  failed.lost = true;
  EXPECT_TRUE(journal_entry(journal_line(plant, failed))->result.lost);
}

}  // namespace batch_plan_test
}  // namespace coppice::bake
