#include "cached_bake.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>

#include "atomic_file.h"
#include "bake_cache.h"
#include "bake_key.h"
#include "cache_index.h"
#include "why_baked.h"

namespace coppice::bake {
namespace {

namespace fs = std::filesystem;

/// Makes the output's folder, and sees before the bake whether it can be written.
Result<void> prepare_output(const fs::path& output) {
  COPPICE_CHECK(make_folder_of(output));
  return try_writing(output);
}

Result<void> keep(const JobCache& cache, const std::string& key, const CachedBake& entry, BatchResult& result) {
  if (cache.folder.empty()) return {};
  const Result<void> stored =
      cache.keeps ? store_cached(cache.folder, key, entry) : Error{Status::io, "the cache's folder took none of the results before"};
  if (stored) cache.line.offer(key);
  if (!stored && cache.needed) return stored.error();
  if (!stored) result.cache_failure = stored.error().message();
  return {};
}

void warn_of_damage(const Error& error, BatchResult& result) {
  if (error.status == Status::bad_file) result.warnings.push_back(error.message() + "; it is not used");
}

/// An entry of a server is worth the time of a bake, and half of its memory: it is in it twice.
EntryWorth worth_of(const PlantCost& cost) {
  constexpr std::uint64_t kLeast_ms = 1'000, kLeastBytes = std::uint64_t{64} << 20;
  return {static_cast<double>(std::max(kLeast_ms, cost.milliseconds)) / 1000.0, std::max(kLeastBytes, cost.memory_bytes / 2)};
}

/// Nothing where it must be baked.
Result<std::optional<CachedBake>> find_entry(const BatchPlant& plant, const JobCache& cache, const std::string& key, DamagedEntry damaged,
                                             BatchResult& result) {
  using Found = std::optional<CachedBake>;
  if (cache.folder.empty()) return Found();
  Result<CachedBake> entry = load_cached(cache.folder, key, damaged);
  if (entry) {
    cache.line.offer(key);
    return Found(*std::move(entry));
  }
  warn_of_damage(entry.error(), result);
  if (!cache.behind.empty()) {
    entry = peek_cached(cache.behind, key);
    if (entry) return Found(*std::move(entry));
    warn_of_damage(entry.error(), result);
  }
  const auto bundle = cache.line.fetch(key, worth_of(plant.cost));
  if (!bundle) return Found();
  entry = read_bundle(*bundle, key);
  if (!entry) {
    cache.line.found_damaged(key);
    warn_of_damage(entry.error(), result);
    return Found();
  }
  COPPICE_CHECK(keep(cache, key, *entry, result));
  return Found(*std::move(entry));
}

/// Why there is no entry: compared with what is in the folders, and on the server of the last plant of that name.
std::vector<std::string> explanation(const std::vector<KeyPart>& parts, const JobCache& cache) {
  if (cache.known == nullptr) return {};
  const auto record = cache.line.fetch_record(name_digits(parts));
  if (!record) return why_baked(parts, *cache.known);
  std::vector<KnownKey> known = *cache.known;
  known.push_back({{}, 0, parts_of_record(*record)});
  return why_baked(parts, known);
}

Result<CachedBake> bake_into(const BatchPlant& plant, const JobCache& cache, const std::vector<KeyPart>& parts,
                             const StageProgress& progress, BatchResult& result) {
  BakeReport report;
  COPPICE_TRY(bytes, bake(plant.input, plant.options, progress, report));
  COPPICE_TRY(key_after, bake_key(plant.input, plant.options));
  if (key_after != result.key) return Error{Status::io, "the plant was changed while it was baked"};
  CachedBake entry{std::move(bytes), report.source_leaves, report.sizes.foliage_bytes, std::move(report.warnings), parts};
  COPPICE_CHECK(keep(cache, result.key, entry, result));
  return entry;
}

/// Publishes it, and says what is known of it.
Result<void> take_entry(const BatchPlant& plant, const CachedBake& entry, BatchResult& result) {
  if (!plant.output.empty()) {
    COPPICE_CHECK(publish_bake(plant.output, entry.bytes));
  }
  result.source_leaves = entry.source_leaves;
  result.file_bytes = entry.bytes.size();
  result.foliage_bytes = entry.foliage_bytes;
  result.warnings.insert(result.warnings.end(), entry.warnings.begin(), entry.warnings.end());
  return {};
}

Result<void> bake_or_load(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress, BatchResult& result) {
  if (!plant.output.empty()) {
    COPPICE_CHECK(prepare_output(plant.output));
  }
  COPPICE_TRY(parts, bake_key_parts(plant.input, plant.options));
  result.key = key_of(parts);
  COPPICE_TRY(entry, find_entry(plant, cache, result.key, DamagedEntry::is_removed, result));
  result.outcome = entry ? BatchOutcome::cached : BatchOutcome::baked;
  if (!entry) {
    result.because = explanation(parts, cache);
    COPPICE_TRY(baked, bake_into(plant, cache, parts, progress, result));
    entry = std::move(baked);
  }
  return take_entry(plant, *entry, result);
}

Result<void> load(const BatchPlant& plant, const JobCache& cache, BatchResult& result) {
  COPPICE_TRY(key, bake_key(plant.input, plant.options));
  result.key = std::move(key);
  COPPICE_TRY(entry, find_entry(plant, cache, result.key, DamagedEntry::stays, result));
  if (!entry) return Error{Status::io, "no cache has it", Error::kNoOffset, result.key};
  result.outcome = BatchOutcome::cached;
  COPPICE_CHECK(make_folder_of(plant.output));
  return take_entry(plant, *entry, result);
}

/// What became of a plant by `work`, which fills it in.
BatchResult result_of(const BatchPlant& plant, const std::function<Result<void>(BatchResult&)>& work) {
  const auto start = std::chrono::steady_clock::now();
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
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace

Result<void> publish_bake(const fs::path& output, const std::vector<std::uint8_t>& bytes) {
  std::error_code error;
  if (fs::is_regular_file(output, error)) {
    const auto there = read_file(output);
    if (there && *there == bytes) return {};
  }
  return write_file_atomically(output, bytes);
}

BatchResult bake_one(const BatchPlant& plant, const JobCache& cache, const StageProgress& progress) {
  return result_of(plant, [&](BatchResult& result) { return bake_or_load(plant, cache, progress, result); });
}

BatchResult load_one(const BatchPlant& plant, const JobCache& cache) {
  return result_of(plant, [&](BatchResult& result) { return load(plant, cache, result); });
}

}  // namespace coppice::bake
