#include "bake_batch.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
#include <set>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include <tbb/info.h>

#include "cache_location.h"
#include "cached_bake.h"
#include "gltf_document.h"
#include "job_processes.h"
#include "plant_pictures.h"
#include "plant_record.h"
#include "temporary_file.h"
#include "text_bytes.h"
#include "usable_memory.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// A plant as errors about its output name it.
std::string told(const BatchPlant& plant) {
  return plant.place.empty() ? plant.input.string() : plant.place + ".output, of " + plant.input.string();
}

/// "name value kB" in a file like /proc/meminfo; 0 where there is none.
std::uint64_t free_memory_bytes() {
  std::ifstream file("/proc/meminfo");
  std::string name, unit;
  std::uint64_t kilobytes = 0;
  while (file >> name >> kilobytes) {
    if (name == "MemAvailable:") return kilobytes * 1024;
    std::getline(file, unit);
  }
  return 0;
}

std::uint32_t processor_count() {
  return static_cast<std::uint32_t>(std::max(1, tbb::info::default_concurrency()));
}

/// Fraction of a whole bake, of a stage's own. The collapse takes nearly all of the time.
double overall_fraction(std::string_view stage, double fraction) {
  if (stage == "import") return 0.05 * fraction;
  if (stage == "areas") return 0.05;
  if (stage == "error table") return 0.93 + 0.05 * fraction;
  if (stage == "pack") return 0.98 + 0.02 * fraction;
  return 0.05 + 0.88 * fraction;
}

/// A batch under way.
struct BatchRun {
  const std::vector<BatchPlant>& plants;
  const BatchOptions& options;
  BatchCaches& caches;
  const std::function<void(const BatchStatus&)>& progress;
  std::vector<PlantCost> costs = costs_of(plants);
  std::vector<BatchResult> results = std::vector<BatchResult>(plants.size());
  std::vector<double> fractions = std::vector<double>(plants.size(), 0.0);
  std::set<std::size_t> running = {};
  std::size_t ended_count = 0;

  void progressed(std::size_t plant, double fraction) {
    running.insert(plant);
    fractions[plant] = fraction;
    show();
  }
  void end(std::size_t plant, BatchResult result) {
    caches.ended(result);
    if (options.ended) options.ended(plants[plant], result);
    results[plant] = std::move(result);
    running.erase(plant);
    fractions[plant] = 1.0;
    ++ended_count;
    show();
  }
  void show() const {
    if (!progress) return;
    BatchStatus status{ended_count, plants.size(), done_fraction(costs, fractions), {}};
    for (const std::size_t plant : running) status.running += (status.running.empty() ? "" : ", ") + plants[plant].input.stem().string();
    progress(status);
  }
};

/// In the job's process.
void draw(const BatchPlant& plant, const BatchOptions& options, BatchResult& result) {
  if (options.pictures.empty() || result.outcome == BatchOutcome::failed) return;
  if (const auto drawn = draw_picture(plant.output, result.key, options.pictures); !drawn)
    result.warnings.push_back("no picture of it: " + drawn.error().message());
}

/// Finds plants in the caches, several at a time, and takes them out of `order`. A process looks up some plants one after another, over one
/// connection to the server.
void look_up(BatchRun& run, std::vector<std::uint32_t>& order) {
  constexpr std::size_t kMaxJobs = 8, kMaxPlantsOfJob = 8;  // they wait for the server more than they compute
  const std::size_t plants_of_job = std::clamp<std::size_t>(order.size() / (2 * kMaxJobs), 1, kMaxPlantsOfJob);
  JobCallbacks callbacks;
  const auto plants_of = [&](std::size_t job) {
    const std::size_t first = job * plants_of_job;
    return std::span(order).subspan(first, std::min(plants_of_job, order.size() - first));
  };
  callbacks.run = [&](std::size_t job, const JobProgress&) {
    std::vector<BatchResult> results;
    for (const std::uint32_t plant : plants_of(job)) {
      results.push_back(load_one(run.plants[plant], run.caches.jobs()));
      draw(run.plants[plant], run.options, results.back());
    }
    return json_line(nlohmann::json(results));
  };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) {
    std::vector<BatchResult> results(plants_of(job).size());  // where a job failed, whoever bakes the plants finds out why
    if (end.failure.empty()) results = nlohmann::json::parse(end.result).get<std::vector<BatchResult>>();
    for (std::size_t i = 0; i < results.size(); ++i) {
      const std::uint32_t plant = plants_of(job)[i];
      if (results[i].outcome == BatchOutcome::cached) {
        run.end(plant, std::move(results[i]));
        continue;
      }
      if (run.plants[plant].failure.empty()) run.caches.missed(results[i]);
      run.results[plant] = std::move(results[i]);
    }
  };
  run_jobs((order.size() + plants_of_job - 1) / plants_of_job, kMaxJobs, callbacks);
  std::erase_if(order, [&](std::uint32_t plant) { return run.results[plant].outcome == BatchOutcome::cached; });
}

void bake_missing(BatchRun& run, const std::vector<std::uint32_t>& order) {
  const std::uint32_t wanted = run.options.job_count > 0 ? run.options.job_count : default_job_count(run.plants);
  const std::uint32_t jobs = std::max(1u, std::min(wanted, static_cast<std::uint32_t>(order.size())));
  const std::uint32_t threads = (processor_count() + jobs - 1) / jobs;
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t job, const JobProgress& job_progress) {
    BatchPlant plant = run.plants[order[job]];
    if (plant.options.thread_count == 0) plant.options.thread_count = threads;
    BatchResult result =
        bake_one(plant, run.caches.jobs(), [&](const char* stage, double fraction) { job_progress(overall_fraction(stage, fraction)); });
    draw(plant, run.options, result);
    return json_line(nlohmann::json(result));
  };
  callbacks.progressed = [&](std::size_t job, double fraction) { run.progressed(order[job], fraction); };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) {
    BatchResult result{.error = end.failure};
    if (end.failure.empty()) result = nlohmann::json::parse(end.result).get<BatchResult>();
    result.peak_rss_bytes = end.peak_rss_bytes;
    result.lost = end.lost;
    const std::vector<std::string>& looked_up = run.results[order[job]].warnings;
    result.warnings.insert(result.warnings.begin(), looked_up.begin(), looked_up.end());
    run.end(order[job], std::move(result));
  };
  run_jobs(order.size(), jobs, callbacks, run.options.limits);
}

void remove_temporaries(const std::vector<BatchPlant>& plants, const fs::path& cache) {
  std::set<fs::path> folders;
  if (!cache.empty()) folders.insert(cache);
  for (const BatchPlant& plant : plants) folders.insert(plant.output.parent_path());
  for (const fs::path& folder : folders) remove_abandoned_temporaries(folder);
}

}  // namespace

const char* outcome_name(BatchOutcome outcome) {
  constexpr std::array kNames{"baked", "cached", "failed"};
  return kNames.at(static_cast<std::size_t>(outcome));
}

void estimate_inputs(std::vector<BatchPlant>& plants) {
  InputCounts counts;
  const fs::path* counted = nullptr;
  for (BatchPlant& plant : plants) {
    // All variants of an input say the same, and one of them is enough to name its files.
    if (counted == nullptr || *counted != plant.input) {
      counts = count_input(plant.input, plant.options.import);
      plant.files = std::move(counts.files);
    }
    counted = &plant.input;
    plant.cost = plant_cost(counts, plant.options);
  }
}

std::vector<PlantCost> costs_of(const std::vector<BatchPlant>& plants) {
  std::vector<PlantCost> costs;
  costs.reserve(plants.size());
  for (const BatchPlant& plant : plants) costs.push_back(plant.cost);
  return costs;
}

bool is_plant_file(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension == ".glb" || extension == ".gltf";
}

Result<std::vector<BatchPlant>> plants_of_folder(const fs::path& folder, const fs::path& output_folder, const BakeOptions& options) {
  std::error_code error;
  std::vector<fs::path> files;
  std::string advice;  // for one in another format
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unreadable;
    if (entry->is_regular_file(unreadable) && is_plant_file(entry->path())) files.push_back(entry->path());
    if (advice.empty()) advice = conversion_advice(entry->path());
  }
  if (error) return system_error("cannot read the folder", folder, error.value());
  if (files.empty())
    return Error{Status::invalid_argument, "no .glb or .gltf in the folder", Error::kNoOffset,
                 folder.string() + (advice.empty() ? "" : ": " + advice)};
  std::ranges::sort(files);
  std::vector<BatchPlant> plants;
  for (const fs::path& file : files) {
    fs::path output = output_folder / file.lexically_relative(folder);
    plants.push_back({file, output.replace_extension(".coppice"), options});
  }
  return plants;
}

std::vector<BatchPlant> expand_variants(const std::vector<BatchPlant>& plants, const JobLimits& limits) {
  std::vector<SourceContents> contents(plants.size());
  std::vector<std::string> failures(plants.size());
  std::vector<std::size_t> jobs;
  for (std::size_t i = 0; i < plants.size(); ++i)
    if (plants[i].all_variants) jobs.push_back(i);
  JobCallbacks callbacks;
  callbacks.run = [&](std::size_t job, const JobProgress&) {
    nlohmann::json names = nlohmann::json::array();
    const auto read = read_contents(plants[jobs[job]].input, plants[jobs[job]].options.import);
    if (!read && read.error().status == Status::out_of_memory) throw std::bad_alloc();
    if (read)
      for (const SourceContents::Variant& variant : read->variants) names.push_back(variant.name);
    return json_line(names);
  };
  callbacks.ended = [&](std::size_t job, const JobEnd& end) {
    failures[jobs[job]] = end.failure;
    if (!end.failure.empty()) return;
    for (const nlohmann::json& name : nlohmann::json::parse(end.result)) contents[jobs[job]].variants.push_back({name, 0, {}});
  };
  run_jobs(jobs.size(), processor_count(), callbacks, limits);
  std::vector<BatchPlant> expanded;
  for (std::size_t i = 0; i < plants.size(); ++i) {
    if (contents[i].variants.empty()) {
      expanded.push_back(plants[i]);
      expanded.back().failure = failures[i];
      continue;
    }
    const std::vector<fs::path> outputs = variant_outputs(plants[i].output, contents[i]);
    for (std::size_t variant = 0; variant < outputs.size(); ++variant) {
      BatchPlant& plant = expanded.emplace_back(plants[i]);
      plant.output = outputs[variant];
      plant.options.import.plant.variant = static_cast<std::uint32_t>(variant + 1);
    }
  }
  return expanded;
}

/// OUT itself may lie in any other folder whose name begins with ".coppice-".
static bool is_own_folder(const fs::path& name) {
  return name == kOwnCache || name == kOwnClusterRuns || name == picture_folder({});
}

Result<void> check_batch(const std::vector<BatchPlant>& plants, const std::vector<fs::path>& other_inputs) {
  const auto refused = [](const char* what, const std::string& whose, const BatchPlant& plant) {
    return Error{Status::invalid_argument, what, Error::kNoOffset, whose + told(plant) + ": " + plant.output.string()};
  };
  std::map<fs::path, const BatchPlant*> plant_of;
  std::map<fs::path, fs::path> input_of, inputs;  // what refers to a file, by how that is named and by where it is
  for (const fs::path& path : other_inputs) input_of.try_emplace(path, path);
  for (const BatchPlant& plant : plants) input_of.try_emplace(plant.input, plant.input);
  for (const BatchPlant& plant : plants)
    for (const fs::path& file : plant.files) input_of.try_emplace(file, plant.input);
  for (const auto& [path, input] : input_of) {
    COPPICE_TRY(place, resolved(path));
    inputs.try_emplace(std::move(place), input);
  }
  for (const BatchPlant& plant : plants) {
    COPPICE_TRY(output, resolved(plant.output));
    const auto [other, is_new] = plant_of.try_emplace(output, &plant);
    if (!is_new) return refused("two plants have the same output", told(*other->second) + " and ", plant);
    if (const auto read = inputs.find(output); read != inputs.end())
      return refused("would be overwritten: an output is an input, or a file that one refers to", read->second.string() + " and ", plant);
    if (output.filename().native().starts_with(".coppice-") || std::ranges::any_of(output, is_own_folder))
      return refused("an output among the files that coppice keeps for itself", "", plant);
  }
  return {};
}

std::uint32_t default_job_count(const std::vector<BatchPlant>& plants) {
  std::vector<std::uint64_t> needs;
  needs.reserve(plants.size());
  for (const BatchPlant& plant : plants) needs.push_back(plant.cost.memory_bytes);
  std::ranges::sort(needs, std::greater<>());
  std::uint64_t left = std::min(free_memory_bytes(), usable_memory_bytes()) / 2;
  std::uint32_t count = 0;
  while (count < needs.size() && count < processor_count() && needs[count] <= left) left -= needs[count++];
  return std::max(1u, count);
}

Result<std::vector<BatchResult>> bake_batch(const std::vector<BatchPlant>& plants, const BatchOptions& options,
                                            const std::function<void(const BatchStatus&)>& progress) {
  COPPICE_TRY(caches, BatchCaches::open(plants, options));
  remove_temporaries(plants, caches.folder());
  BatchRun run{plants, options, caches, progress};
  run.show();
  std::vector<std::uint32_t> order = slowest_first(run.costs);
  if (caches.jobs().server != nullptr || options.look_up_only) look_up(run, order);
  if (!options.look_up_only) bake_missing(run, order);
  // A job that was killed may have been writing.
  remove_temporaries(plants, caches.folder());
  if (options.cache_reported) options.cache_reported(caches.report());
  return std::move(run.results);
}

}  // namespace coppice::bake
