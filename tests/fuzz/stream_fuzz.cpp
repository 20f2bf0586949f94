// libFuzzer: the bytes are a script of what happens to the streamer: frames and what they want, and reads that come late, short, with wrong
// bytes or not at all, memory that is refused, uploads that fail, plants that open and close. Whatever the script, only right nodes are
// handed out, in order; afterwards, with everything in order again, the streamer settles; and in the end nothing is left behind.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "check.h"
#include "fake_gpu.h"
#include "fake_hooks.h"
#include "pack.h"
#include "random_tree.h"
#include "streamer.h"

namespace {

using coppice::test::FakeGpuPlant;
using coppice::test::FakeRead;

constexpr std::uint32_t kMaxPlants = 3;
constexpr std::array<const char*, 3> kPaths = {"a", "b", "missing"};

std::uint64_t clock_now_ns = 0;
std::uint64_t clock_ns() {
  return clock_now_ns;
}

std::map<std::string, std::vector<std::uint8_t>> plant_files() {
  coppice::bake::PackSizes sizes;
  const auto packed = [&](const coppice::test::RandomPlantOptions& options) {
    return *coppice::bake::pack(coppice::test::random_plant(options), sizes);
  };
  return {{"a", packed({.leaf_count = 1300, .seed = 5})}, {"b", packed({.leaf_count = 700, .seed = 6, .leaf_mesh_count = 2})}};
}

/// What goes wrong with a read.
enum class Fault : std::uint8_t { none, fails, comes_short, is_wrong, is_empty, count };

class Script {
 public:
  explicit Script(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  /// 0 once the script is over.
  std::uint8_t next() { return is_over() ? 0 : bytes_[at_++]; }
  [[nodiscard]] bool is_over() const { return at_ >= bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Everything round one streamer.
class World {
 public:
  explicit World(Script script) : script_(script) {
    clock_now_ns = 1'000'000'000;  // the same for every script
    static const auto files = plant_files();
    io_.files = files;
    io_.deferred = true;  // hands reads to us
    jobs_.deferred = script_.next() % 2 == 1;
    coppice::StreamerOptions options;
    options.gpu = {.plant_bytes = 1000};
    options.max_plants = kMaxPlants;
    options.max_in_flight = 1 + script_.next() % 16;
    options.clock_ns = clock_ns;
    auto created = coppice::Streamer::create({allocator_.hook(), jobs_.hook(), io_.hook(), log_.hook()}, ledger_, options);
    COPPICE_ASSERT(created);
    streamer_ = *std::move(created);
    gpu_ = std::make_unique<coppice::test::FakeGpu>(*streamer_, ledger_);
    demands_.resize(kMaxPlants);
  }

  void run() {
    constexpr int kMaxSteps = 400;
    for (int i = 0; i < kMaxSteps && !script_.is_over(); ++i) step();
  }

  /// Nothing goes wrong any more and there is room for all: what can come has come, and is right.
  void settle() {
    allocator_.fail_at = SIZE_MAX;
    allocator_.fail_for_good = false;
    jobs_.deferred = false;
    gpu_->frames_behind = 0;
    ledger_.set_budget(256u << 20);
    take_elsewhere(0);
    for (coppice::PlantDemand& demand : demands_) demand = coppice::test::demand_of(3000.0f);
    for (int i = 0; i < 600 && (i < 5 || !is_settled()); ++i) {
      answer_all();
      jobs_.run_all();
      frame();
    }
    COPPICE_ASSERT(is_settled());
  }

  /// Against those of open_and_settle().
  void check_nodes(const std::map<std::string, FakeGpuPlant>& reference) const {
    for (const auto& [index, plant] : gpu_->plants) {
      if (!streamer_->is_open(index)) continue;
      const FakeGpuPlant& right = reference.at(streamer_->path(index));
      COPPICE_ASSERT(plant.nodes.size() <= right.nodes.size());
      for (std::size_t i = 1; i < plant.nodes.size(); ++i)
        COPPICE_ASSERT(plant.nodes[i].corners == right.nodes[i].corners && plant.nodes[i].card == right.nodes[i].card);
    }
  }

  void close() {
    for (std::uint32_t plant = 0; plant < kMaxPlants; ++plant) close_plant(plant);
    answer_all();
    jobs_.run_all();
    for (int i = 0; i < 8; ++i) frame();
    gpu_.reset();
    streamer_.reset();
    COPPICE_ASSERT(allocator_.live_bytes == 0 && io_.open_count == 0);
  }

  /// What a clean run ends with, by path.
  std::map<std::string, FakeGpuPlant> open_and_settle() {
    start_open(0);
    start_open(1);
    settle();
    std::map<std::string, FakeGpuPlant> plants;
    for (const auto& [index, plant] : gpu_->plants) plants[streamer_->path(index)] = plant;
    return plants;
  }

 private:
  enum class Plant : std::uint8_t { none, opening, open, closing };

  void step() {
    switch (script_.next() % 13) {
      case 0:
        return want();
      case 1:
        return frame();
      case 2:
        return answer_next(static_cast<Fault>(script_.next() % static_cast<std::uint8_t>(Fault::count)));
      case 3:
        return answer_next(Fault::none);
      case 4:
        return answer_all();
      case 5:
        return jobs_.run_all();
      case 6:
        return ledger_.set_budget(std::uint64_t{script_.next()} << 12);
      case 7:
        return start_open(script_.next() % kPaths.size());
      case 8:
        return close_plant(script_.next() % kMaxPlants);
      case 9:
        return fail_uploads(script_.next());
      case 10:
        return refuse_memory(script_.next());
      case 11:
        gpu_->frames_behind = script_.next() % 4;
        return;
      default:
        return take_elsewhere(std::uint64_t{script_.next()} << 8);
    }
  }

  /// Others than the streamer take bytes of the ledger: some as they are asked for, the rest in any case.
  void take_elsewhere(std::uint64_t bytes) {
    ledger_.release(std::exchange(elsewhere_bytes_, bytes));
    (void)ledger_.fits(bytes);
    ledger_.reserve(bytes);
  }

  void want() {
    const std::uint8_t plant = script_.next() % kMaxPlants, size = script_.next();
    demands_[plant] = size == 0 ? coppice::PlantDemand{} : coppice::test::demand_of(static_cast<float>(size) * 12.0f);
  }

  void frame() {
    clock_now_ns += 16'000'000;
    for (std::uint32_t plant = 0; plant < kMaxPlants; ++plant) finish_open(plant);
    gpu_->frame(view_, demands_);
    for (const std::uint32_t plant : std::exchange(gpu_->closed, {})) {
      COPPICE_ASSERT(states_[plant] == Plant::closing);
      states_[plant] = Plant::none;
    }
    for (const std::string& line : std::exchange(log_.lines, {})) COPPICE_ASSERT(line.find(": ") != std::string::npos);
  }

  void finish_open(std::uint32_t plant) {
    if (states_[plant] != Plant::opening) return;
    const auto finished = streamer_->finish_open(plant);
    if (finished) states_[plant] = *finished ? Plant::open : Plant::none;
  }

  void start_open(std::size_t path) {
    const auto plant = streamer_->start_open(kPaths[path]);
    if (!plant) return;
    COPPICE_ASSERT(*plant < kMaxPlants && states_[*plant] == Plant::none);
    states_[*plant] = Plant::opening;
  }

  void close_plant(std::uint32_t plant) {
    if (states_[plant] == Plant::opening) {
      streamer_->cancel_open(plant);
      states_[plant] = Plant::none;
    } else if (states_[plant] == Plant::open) {
      streamer_->close_plant(plant);
      states_[plant] = Plant::closing;
    }
  }

  /// A frame whose copies the device refuses, as many as the mask says.
  void fail_uploads(std::uint8_t mask) {
    gpu_->uploads = false;
    frame();
    gpu_->uploads = true;
    const coppice::Error error = (mask & 1) != 0 ? coppice::Error{coppice::Status::out_of_memory, "no device memory"}
                                                 : coppice::Error{coppice::Status::device_lost, "the device is gone"};
    int i = 0;
    for (const coppice::DecodedChunk& chunk : streamer_->take_decoded(UINT64_MAX))
      if ((mask >> (1 + i++ % 7) & 1) != 0 && streamer_->begin_upload(chunk.id)) streamer_->upload_failed(chunk.id, error);
  }

  void refuse_memory(std::uint8_t when) {
    allocator_.fail_at = allocator_.calls + when / 2;
    allocator_.fail_for_good = when % 2 == 1;
    if (when == 255) allocator_.fail_at = SIZE_MAX;
  }

  void answer_all() {
    while (!io_.waiting.empty()) answer_next(Fault::none);
  }

  void answer_next(Fault fault) {
    if (io_.waiting.empty()) return;
    const FakeRead read = io_.waiting.front();
    io_.waiting.pop_front();
    const std::vector<std::uint8_t>& file = io_.files.at(io_.handles.at(static_cast<std::size_t>(read.file)));
    COPPICE_ASSERT(read.offset <= file.size() && read.bytes <= file.size() - read.offset);
    auto* destination = static_cast<std::uint8_t*>(read.destination);
    std::size_t there = fault == Fault::comes_short ? read.bytes * script_.next() / 256 : read.bytes;
    if (fault == Fault::fails || fault == Fault::is_empty) there = 0;
    if (there > 0) std::memcpy(destination, file.data() + read.offset, there);
    if (fault == Fault::is_wrong && there > 0) {
      const std::size_t place = script_.next() | std::size_t{script_.next()} << 8;
      destination[place % there] ^= static_cast<std::uint8_t>(1u << script_.next() % 8);
    }
    read.done(read.argument, fault == Fault::fails ? -1 - script_.next() : static_cast<std::int64_t>(there));
  }

  [[nodiscard]] bool is_settled() const {
    const coppice::StreamStats stats = streamer_->stats();
    return stats.all().in_flight == 0 && stats.all().wanted == 0 && io_.waiting.empty() &&
           std::ranges::find(states_, Plant::opening) == states_.end();
  }

  Script script_;
  coppice::test::FakeAllocator allocator_;
  coppice::test::FakeJobs jobs_;
  coppice::test::FakeIo io_;
  coppice::test::FakeLog log_;
  coppice::LodView view_;
  std::vector<coppice::PlantDemand> demands_;
  std::array<Plant, kMaxPlants> states_{};
  coppice::Ledger ledger_{256u << 20};
  std::uint64_t elsewhere_bytes_ = 0;
  std::unique_ptr<coppice::Streamer> streamer_;
  std::unique_ptr<coppice::test::FakeGpu> gpu_;
};

const std::map<std::string, FakeGpuPlant>& reference() {
  static const std::map<std::string, FakeGpuPlant> right = [] {
    World world(Script({}));
    auto plants = world.open_and_settle();
    COPPICE_ASSERT(plants.at("a").nodes.size() == 2 * 1300 - 1 && plants.at("b").nodes.size() == 2 * 700 - 1);
    world.close();
    return plants;
  }();
  return right;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const bool is_ready = [] {
    GTEST_FLAG_SET(break_on_failure, true);  // FakeGpu's expectations
    return !reference().empty();
  }();
  COPPICE_ASSERT(is_ready);
  World world(Script({data, size}));
  world.run();
  world.settle();
  world.check_nodes(reference());
  world.close();
  return 0;
}
