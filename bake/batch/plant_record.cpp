#include "plant_record.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "temporary_file.h"
#include "text_bytes.h"

namespace coppice::bake {
namespace {

using OrderedJson = nlohmann::ordered_json;

BatchOutcome outcome_of(const std::string& name) {
  for (const BatchOutcome outcome : {BatchOutcome::baked, BatchOutcome::cached})
    if (name == outcome_name(outcome)) return outcome;
  return BatchOutcome::failed;
}

}  // namespace

double bytes_per_leaf(const BatchResult& result) {
  return result.source_leaves > 0 ? static_cast<double>(result.foliage_bytes) / result.source_leaves : 0.0;
}

OrderedJson plant_record(const BatchPlant& plant, const BatchResult& result) {
  OrderedJson json = {{"input", plant.input.string()}, {"output", plant.output.string()}, {"outcome", outcome_name(result.outcome)}};
  if (result.outcome == BatchOutcome::failed)
    json.update({{"error", result.error}, {"lost", result.lost}});
  else
    json.update({{"source_leaves", result.source_leaves},
                 {"file_bytes", result.file_bytes},
                 {"foliage_bytes", result.foliage_bytes},
                 {"bytes_per_leaf", bytes_per_leaf(result)}});
  json.update({{"key", result.key},
               {"seconds", result.seconds},
               {"peak_rss_bytes", result.peak_rss_bytes},
               {"warnings", result.warnings},
               {"because", result.because}});
  return json;
}

std::string journal_line(const BatchPlant& plant, const BatchResult& result) {
  return plant_record(plant, result).dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::optional<JournalEntry> journal_entry(std::string_view line) {
  const OrderedJson json = OrderedJson::parse(line, nullptr, false);
  try {
    JournalEntry entry;
    entry.output = json.at("output").get<std::string>();
    BatchResult& result = entry.result;
    result.outcome = outcome_of(json.at("outcome").get<std::string>());
    result.error = json.value("error", std::string());
    result.lost = json.value("lost", false);
    result.source_leaves = json.value("source_leaves", 0u);
    result.file_bytes = json.value("file_bytes", std::uint64_t{0});
    result.foliage_bytes = json.value("foliage_bytes", std::uint64_t{0});
    result.key = json.at("key").get<std::string>();
    result.seconds = json.at("seconds").get<double>();
    result.peak_rss_bytes = json.at("peak_rss_bytes").get<std::uint64_t>();
    result.warnings = json.at("warnings").get<std::vector<std::string>>();
    result.because = json.at("because").get<std::vector<std::string>>();
    return entry;
  } catch (const OrderedJson::exception&) {
    return {};
  }
}

Journal::Journal(std::filesystem::path path, int file) : path_(std::move(path)), file_(file) {}

Journal::Journal(Journal&& other) noexcept : path_(std::move(other.path_)), file_(std::exchange(other.file_, -1)) {}

Journal::~Journal() {
  if (file_ >= 0) ::close(file_);
}

Result<Journal> Journal::open(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (file < 0) return system_error("cannot write", path, errno);
  return Journal(path, file);
}

Result<void> Journal::add(const BatchPlant& plant, const BatchResult& result) {
  COPPICE_CHECK(write_all(file_, bytes_of(journal_line(plant, result)), path_));
  // Others read it while it grows, through a file system that may keep it back. Some cannot sync; then they see it when it is closed.
  static_cast<void>(::fdatasync(file_));
  return {};
}

}  // namespace coppice::bake
