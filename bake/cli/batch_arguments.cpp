#include "batch_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <system_error>

#include "batch_manifest.h"
#include "batch_report.h"
#include "printable.h"
#include "progress_bar.h"
#include "slurm.h"
#include "temporary_file.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// A script's comments and JSON hold no newline and nothing but UTF-8.
Result<void> check_words(const ClusterBatch& batch) {
  std::vector<std::string> words{batch.output_folder.string(), batch.coppice.string()};
  words.insert(words.end(), batch.task_options.begin(), batch.task_options.end());
  words.insert(words.end(), batch.sbatch_options.begin(), batch.sbatch_options.end());
  for (const std::string& word : words)
    if (!is_printable(word)) return Error{Status::invalid_argument, "tasks' scripts cannot hold this", Error::kNoOffset, printable(word)};
  return {};
}

volatile std::sig_atomic_t interrupted = 0;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): a signal handler's

/// While it lives, Ctrl-C is a wish to leave.
class LeaveOnInterrupt {
 public:
  LeaveOnInterrupt() {
    interrupted = 0;
    struct sigaction action {};
    action.sa_handler = [](int) { interrupted = 1; };
    ::sigaction(SIGINT, &action, &before_);
  }
  LeaveOnInterrupt(const LeaveOnInterrupt&) = delete;
  LeaveOnInterrupt& operator=(const LeaveOnInterrupt&) = delete;
  ~LeaveOnInterrupt() { ::sigaction(SIGINT, &before_, nullptr); }

 private:
  struct sigaction before_ {};
};

}  // namespace

void add_cache_options(CLI::App& command, CacheArguments& arguments) {
  command
      .add_option("--cache", arguments.where,
                  "A cache that people and machines share: a folder, in place of OUT/.coppice-cache, or an address like https://host/path, "
                  "behind it; without it that of COPPICE_CACHE. Credentials are in COPPICE_CACHE_CREDENTIALS (USER:PASSWORD or Bearer "
                  "TOKEN) or ~/.netrc. A cache that is of no use costs seconds, and no plant")
      ->type_name("FOLDER|URL")
      ->envname(kCacheVariable);
  command.add_option("--cache-mode", arguments.mode, "Whether results are sent to the shared cache, or it is only read")
      ->check(CLI::IsMember({"read", "read-write"}))
      ->type_name("read|read-write")
      ->capture_default_str();
  command.add_flag("--no-cache", arguments.none, "Bake everything and keep nothing but the outputs");
  command.add_flag("--explain", arguments.explain,
                   "Say why each plant was baked: what its key differs in from the nearest entry in the cache");
}

void check_cache_arguments(const CacheArguments& arguments) {
  if (arguments.mode == "read" && arguments.where.empty())
    throw CLI::ValidationError("--cache-mode", std::string("there is no shared cache: name one with --cache or ") + kCacheVariable);
}

Result<void> set_caches(const CacheArguments& arguments, const std::filesystem::path& output, BatchOptions& options) {
  options.explain = arguments.explain;
  if (arguments.none) return {};
  options.cache = output / kOwnCache;
  if (arguments.where.empty()) return {};
  COPPICE_TRY(location, parse_cache_location(arguments.where));
  COPPICE_TRY(credentials, credentials_of_environment());
  options.shared = {std::move(location), arguments.mode == "read" ? CacheMode::read : CacheMode::read_write, std::move(credentials)};
  return {};
}

std::vector<std::string> shared_cache_options(const CacheArguments& arguments) {
  // Nothing of an address that nobody has looked at.
  if (arguments.none || arguments.where.empty()) return {};
  return {"--cache-mode", arguments.mode, "--cache", arguments.where};
}

void add_cluster_options(CLI::App& command, ClusterArguments& arguments) {
  command.add_flag("--slurm", arguments.slurm,
                   "Bake on the nodes of a Slurm cluster. OUT and the inputs must be in folders that all nodes share. What follows -- are "
                   "options of sbatch. The same command again takes up where this one was stopped");
  command.add_flag("--print", arguments.print,
                   "With --slurm: print the script of the tasks instead of submitting it, for other schedulers");
  command
      .add_option("--coppice", arguments.coppice, "With --slurm: where the nodes have this program; by default where this machine has it")
      ->type_name("PATH");
  command.add_option("sbatch", arguments.sbatch_options, "With --slurm, after --: options of sbatch, as in -- -p long --mem 8G")
      ->type_name("-- OPTION ...");
}

std::string sbatch_hint(const std::vector<std::string>& words) {
  const auto has = [&words](const char* word) { return std::ranges::find(words, word) != words.end(); };
  return has("--slurm") && !has("--") ? "Options of sbatch follow --, as in --slurm -- -p long\n" : "";
}

void check_cluster_arguments(const ClusterArguments& arguments) {
  if (const std::string word = refused_sbatch_option(arguments.sbatch_options); !word.empty())
    throw CLI::ValidationError(word, "not with bake-all, which submits, finds and waits for the tasks itself");
  if (arguments.slurm) return;
  if (arguments.print) throw CLI::ValidationError("--print", "needs --slurm");
  if (!arguments.coppice.empty()) throw CLI::ValidationError("--coppice", "needs --slurm");
  if (!arguments.sbatch_options.empty())
    throw CLI::ValidationError(arguments.sbatch_options.front(), "one input too many; options of sbatch need --slurm");
}

Result<void> prepare_cluster_batch(const ClusterArguments& arguments, ClusterBatch& batch) {
  batch.sbatch_options = arguments.sbatch_options;
  batch.coppice = arguments.coppice;
  std::error_code error;
  if (batch.coppice.empty()) batch.coppice = fs::read_symlink("/proc/self/exe", error);
  if (error) return system_error("cannot tell where this program is", "/proc/self/exe", error.value());
  for (const BatchPlant& plant : batch.plants) {
    COPPICE_TRY(entry, manifest_entry(plant, batch.output_folder));
    batch.entries.push_back(std::move(entry));
  }
  return check_words(batch);
}

Result<std::optional<std::vector<BatchResult>>> follow_on_cluster(ClusterBatch& batch, bool quiet) {
  ProgressBar bar(quiet ? ProgressBar::Visibility::never : ProgressBar::Visibility::on_terminal);
  batch.progress = [&bar](const BatchStatus& status) { show_batch(bar, status); };
  batch.warn = [&bar](const std::string& line) {
    bar.clear();
    std::fprintf(stderr, "coppice: %s\n", printable(line).c_str());
  };
  batch.say = [&batch, quiet](const std::string& line) {
    if (!quiet) batch.warn(line);
  };
  batch.is_stopped = [] { return interrupted != 0; };
  const LeaveOnInterrupt leave;
  auto results = bake_on_cluster(batch);
  bar.clear();
  return results;
}

}  // namespace coppice::bake
