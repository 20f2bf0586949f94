#include "cached_bake.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "atomic_file.h"
#include "bake_cache.h"
#include "bake_key.h"
#include "inspect.h"
#include "printable.h"
#include "reader.h"
#include "stopwatch.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

Result<void> keep(const JobCache& cache, const std::string& key, const CachedBake& entry, BatchResult& result) {
  if (cache.folder.empty()) return {};
  const Result<void> stored = cache.folder_failures.is_off() ? Error{Status::io, "the cache's folder took none of the results before"}
                                                             : store_cached(cache.folder, key, entry);
  if (!stored && cache.needed) return stored.error();
  if (!stored) result.folder_failure = stored.error().message();
  return {};
}

/// What a server may take of a plant's time: a tenth of what the bake is estimated to take, up to two minutes.
double worth_s(const PlantCost& cost) {
  return std::min(120.0, 1e-4 * static_cast<double>(cost.milliseconds));
}

/// The most that an entry may have: a bake would take twice as much memory. Others may put anything in its place.
std::uint64_t max_entry_bytes(const PlantCost& cost) {
  return cost.memory_bytes == 0 ? kMaxEntryBytes : std::clamp(cost.memory_bytes / 2, std::uint64_t{64} << 20, kMaxEntryBytes);
}

RequestLimits limits_of(const PlantCost& cost) {
  RequestLimits limits;
  limits.bytes = max_entry_bytes(cost);
  limits.seconds += worth_s(cost);
  return limits;
}

void send(const BatchPlant& plant, const JobCache& cache, const CachedBake& entry, BatchResult& result) {
  if (cache.server == nullptr || cache.server_mode == CacheMode::read) return;
  Stopwatch watch;
  const auto sent = cache.server->put(result.key, entry, limits_of(plant.cost));
  result.sent = static_cast<bool>(sent);
  // What was sent at a usual rate is no time lost.
  constexpr double kUsualBytesPerSecond = 1e6;
  result.lost_s = std::max(0.0, watch.lap() - (sent ? static_cast<double>(entry.bytes.size()) / kUsualBytesPerSecond : 0.0));
  if (!sent) result.server_failure = sent.error().message();
}

void warn_of_damage(const Error& error, BatchResult& result) {
  if (error.status == Status::bad_file || error.status == Status::unsupported)
    result.warnings.push_back(error.message() + "; it is not used");
}

/// Nothing where the folders lack it. Whoever bakes the plant removes a damaged entry and warns of it.
std::optional<CachedBake> find_entry(const BatchPlant& plant, const JobCache& cache, const std::string& key, DamagedEntry damaged,
                                     BatchResult& result) {
  const auto usable = [&](Result<CachedBake> found) {
    if (!found && damaged == DamagedEntry::is_removed) warn_of_damage(found.error(), result);
    return found ? std::optional(*std::move(found)) : std::nullopt;
  };
  if (cache.folder.empty()) return {};
  std::optional<CachedBake> entry = usable(load_cached(cache.folder, key, damaged, max_entry_bytes(plant.cost)));
  if (!entry && !cache.read_only.empty()) entry = usable(peek_cached(cache.read_only, key, max_entry_bytes(plant.cost)));
  return entry;
}

/// A checksum is no proof: the file is checked as any that a stranger made, and has to be of this name and metric.
/// errors  bad_file
Result<void> check_foreign(const BatchPlant& plant, const CachedBake& entry) {
  constexpr std::size_t kWholeNameBytes = sizeof(coppice_file_plant::name) - 4;  // longer ones are cut at a character
  COPPICE_CHECK(verify(entry.bytes));
  COPPICE_TRY(file, read_front(entry.bytes, entry.bytes.size()));
  const std::string name = printable(plant.input.stem().string()), kept = file.plant.name;
  if (file.plant.metric == static_cast<std::uint32_t>(plant.options.metric) && name.starts_with(kept) &&
      kept.size() >= std::min(name.size(), kWholeNameBytes))
    return {};
  return Error{Status::bad_file, "another plant", Error::kNoOffset, printable(kept)};
}

Result<std::optional<CachedBake>> get_checked(const BatchPlant& plant, HttpCache& server, const std::string& key) {
  COPPICE_TRY(entry, server.get(key, limits_of(plant.cost)));
  const Result<void> checked = entry ? check_foreign(plant, *entry) : Result<void>();
  if (checked) return entry;
  return Error{checked.error().status, "an entry of the cache is wrong", Error::kNoOffset,
               server.url() + "/" + key + ": " + checked.error().message()};
}

/// Nothing where the server lacks it or is of no use.
Result<std::optional<CachedBake>> fetch_entry(const BatchPlant& plant, const JobCache& cache, const std::string& key, BatchResult& result) {
  Stopwatch watch;
  auto entry = get_checked(plant, *cache.server, key);
  const double saved_s = entry && *entry ? 1e-3 * static_cast<double>(plant.cost.milliseconds) : 0.0;
  result.lost_s = std::max(0.0, watch.lap() - saved_s);
  cache.server->lose(result.lost_s);
  if (!entry && entry.error().status == Status::out_of_memory) return entry.error();
  if (!entry) {
    warn_of_damage(entry.error(), result);
    if (entry.error().status != Status::bad_file) result.server_failure = entry.error().message();
    return std::optional<CachedBake>();
  }
  if (*entry) {
    COPPICE_CHECK(keep(cache, key, **entry, result));
  }
  return *std::move(entry);
}

Result<CachedBake> bake_into(const BatchPlant& plant, const JobCache& cache, const std::vector<KeyPart>& parts,
                             const StageProgress& progress, BatchResult& result) {
  BakeReport report;
  BakeOptions options = plant.options;
  bool has_changed = false;
  options.import.on_read = [&](std::string_view uri, std::span<const std::uint8_t> file) {
    has_changed = has_changed || !is_part_of(parts, uri, file);
  };
  COPPICE_TRY(bytes, bake(plant.input, options, progress, report));
  if (has_changed) return Error{Status::io, "the plant was changed while it was baked"};
  CachedBake entry{std::move(bytes), report.source_leaves, report.sizes.foliage_bytes, std::move(report.warnings), parts};
  COPPICE_CHECK(keep(cache, result.key, entry, result));
  send(plant, cache, entry, result);
  return entry;
}

/// The output is then the entry's file: written only if it is anything else.
Result<void> take_entry(const BatchPlant& plant, const CachedBake& entry, BatchResult& result) {
  if (!plant.output.empty()) {
    const auto there = read_file(plant.output, entry.bytes.size() + 1);
    if (!there || *there != entry.bytes) {
      COPPICE_CHECK(write_file_atomically(plant.output, entry.bytes));
    }
  }
  result.source_leaves = entry.source_leaves;
  result.file_bytes = entry.bytes.size();
  result.foliage_bytes = entry.foliage_bytes;
  result.warnings.insert(result.warnings.end(), entry.warnings.begin(), entry.warnings.end());
  return {};
}

Result<void> bake_or_load(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress, BatchResult& result) {
  if (!plant.output.empty()) {
    COPPICE_CHECK(make_folder_of(plant.output));
    COPPICE_CHECK(try_writing(plant.output));  // before the bake
  }
  COPPICE_TRY(parts, bake_key_parts(plant.input, plant.options));
  result.key = key_of(parts);
  std::optional<CachedBake> entry = find_entry(plant, cache, result.key, DamagedEntry::is_removed, result);
  result.outcome = entry ? BatchOutcome::cached : BatchOutcome::baked;
  if (!entry) {
    if (cache.known != nullptr) result.because = why_baked(parts, *cache.known);
    COPPICE_TRY(baked, bake_into(plant, cache, parts, progress, result));
    entry = std::move(baked);
  }
  return take_entry(plant, *entry, result);
}

Result<void> load(const BatchPlant& plant, const JobCache& cache, BatchResult& result) {
  COPPICE_TRY(key, bake_key(plant.input, plant.options));
  result.key = std::move(key);
  std::optional<CachedBake> entry = find_entry(plant, cache, result.key, DamagedEntry::stays, result);
  if (!entry && cache.server != nullptr) {
    COPPICE_CHECK(move_into(entry, fetch_entry(plant, cache, result.key, result)));
  }
  if (!entry) return Error{Status::io, "no cache has it", Error::kNoOffset, result.key};
  result.outcome = BatchOutcome::cached;
  COPPICE_CHECK(make_folder_of(plant.output));
  return take_entry(plant, *entry, result);
}

BatchResult result_of(const BatchPlant& plant, const std::function<Result<void>(BatchResult&)>& work) {
  Stopwatch watch;
  BatchResult result;
  if (!plant.failure.empty()) {
    result.error = plant.failure;
    return result;
  }
  if (const auto done = work(result); !done) {
    result.outcome = BatchOutcome::failed;
    const Error& error = done.error();
    result.error = error.status == Status::out_of_memory ? "out of memory" + memory_limit_hint() : error.message();
  }
  result.seconds = watch.lap();
  return result;
}

}  // namespace

BatchResult bake_one(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress) {
  return result_of(plant, [&](BatchResult& result) { return bake_or_load(plant, cache, progress, result); });
}

BatchResult bake_cached(const BatchPlant& plant, const fs::path& cache, const StageProgress& progress) {
  const auto made = make_folder(cache);
  if (made) return bake_one(plant, {.folder = cache}, progress);
  BatchResult result;
  result.error = made.error().message();
  return result;
}

BatchResult load_one(const BatchPlant& plant, const JobCache& cache) {
  return result_of(plant, [&](BatchResult& result) { return load(plant, cache, result); });
}

Result<void> BatchCaches::open_folder(const BatchOptions& options) {
  const fs::path& shared = options.shared.location.folder;
  const bool is_read = options.shared.mode == CacheMode::read;
  report_.where = shared.empty() ? options.cache.string() : shared.string();
  if (!shared.empty() && !is_read) {
    Result<void> usable = make_folder(shared);
    if (usable) usable = try_writing(shared / "entry");
    if (usable) jobs_.folder = shared;
    if (usable) return {};
    report_.trouble = usable.error().message() + "; " + options.cache.string() + " was used instead";
  }
  if (!shared.empty() && is_read) jobs_.read_only = shared;
  std::error_code error;
  if (!jobs_.read_only.empty() && !fs::is_directory(shared, error)) report_.trouble = "there is no such folder";
  COPPICE_CHECK(make_folder(options.cache));
  jobs_.folder = options.cache;
  const LockKind kind = options.other_batches ? LockKind::shared : LockKind::alone;
  COPPICE_TRY(lock, lock_file(options.cache / "lock", kind, "another bake-all is writing to this folder"));
  lock_.emplace(std::move(lock));
  return {};
}

Result<BatchCaches> BatchCaches::open(const std::vector<BatchPlant>& plants, const BatchOptions& options) {
  BatchCaches caches;
  caches.jobs_.needed = false;
  if (options.cache.empty()) return caches;
  COPPICE_CHECK(caches.open_folder(options));
  if (options.explain) {
    caches.known_ = std::make_unique<std::vector<KnownKey>>(known_keys(caches.jobs_.folder));
    if (!caches.jobs_.read_only.empty())
      for (KnownKey& known : known_keys(caches.jobs_.read_only)) caches.known_->push_back(std::move(known));
    caches.jobs_.known = caches.known_.get();
  }
  const SharedCache& shared = options.shared;
  if (shared.location.url.empty()) return caches;
  double most_lost_s = 10.0;
  for (const BatchPlant& plant : plants) most_lost_s += worth_s(plant.cost);
  caches.server_ = std::make_unique<HttpCache>(shared.location.url, shared.credentials, most_lost_s);
  caches.jobs_.server = caches.server_.get();
  caches.jobs_.server_mode = shared.mode;
  caches.report_.where = shared.location.url;
  return caches;
}

void BatchCaches::note_use(const BatchResult& result) {
  if (report_.trouble.empty()) report_.trouble = result.server_failure;
  if (report_.trouble.empty() && !result.folder_failure.empty())
    report_.trouble = (server_ ? "not all is kept beside the outputs: " : "") + result.folder_failure;
  if (result.outcome == BatchOutcome::baked || !result.folder_failure.empty()) jobs_.folder_failures.count(!result.folder_failure.empty());
  if (!server_) return;
  server_->count(!result.server_failure.empty());
  report_.gave_up = report_.gave_up || server_->is_off();
}

void BatchCaches::ended(const BatchResult& result) {
  if (server_) server_->lose(result.lost_s);
  const bool is_baked = result.outcome == BatchOutcome::baked;
  const std::string& failure = server_ ? result.server_failure : result.folder_failure;
  if (result.outcome == BatchOutcome::cached) ++report_.found;
  if (is_baked && !server_) ++report_.lacking;
  if (server_ ? result.sent || !failure.empty() : is_baked) ++(failure.empty() ? report_.sent : report_.unsent);
  if (is_baked || !result.server_failure.empty() || !result.folder_failure.empty()) note_use(result);
}

void BatchCaches::missed(const BatchResult& result) {
  ++report_.lacking;
  if (server_) server_->lose(result.lost_s);
  note_use(result);
}

}  // namespace coppice::bake
