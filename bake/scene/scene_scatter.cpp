// Each species has its share of the plants, and those with the widest crowns are placed first, since they hardly fit into what small ones
// leave free. The square is cut into plots of some hundred plants each, visited along a Z-shaped curve. A plot's share of a species is its
// share of that species' density, summed up. Within it places are drawn at random; a place is kept with the probability of its density, and
// only if it is far enough from earlier plants. Plants that do not fit into a plot go to the next plots, and at the end to a second pass;
// plants that do not fit anywhere are replaced by other species.

#include "scene_scatter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>

#include "image_decode.h"
#include "seeded_random.h"

namespace coppice::bake {
namespace {

constexpr float kCrownShare = 0.62f;  // relative to the bounding sphere: trees are taller than wide
constexpr std::uint32_t kPlantsAPlot = 256;
constexpr std::uint32_t kMaxPlots = 1024;  // on each side
constexpr int kAttempts = 24;              // for each plant, before it goes to the next plot
constexpr float kGrove_m = 70.0f, kClearing_m = 110.0f;

/// Smooth noise in [-1, 1] with features as large as about one unit.
float noise(float x, float z, std::uint64_t seed) {
  const float x0 = std::floor(x), z0 = std::floor(z);
  const auto corner = [&](float dx, float dz) {
    const auto cell_x = static_cast<std::uint64_t>(static_cast<std::int64_t>(x0 + dx));
    const auto cell_z = static_cast<std::uint64_t>(static_cast<std::int64_t>(z0 + dz));
    return static_cast<float>(mix_bits(mix_bits(seed ^ cell_x * 0x9e3779b97f4a7c15u) ^ cell_z) >> 40) * 0x1p-23f - 1.0f;
  };
  const auto fade = [](float t) { return t * t * (3.0f - 2.0f * t); };
  const float u = fade(x - x0), v = fade(z - z0);
  return std::lerp(std::lerp(corner(0, 0), corner(1, 0), u), std::lerp(corner(0, 1), corner(1, 1), u), v);
}

float crown_radius_m(const ScatterSpecies& species) {
  return kCrownShare * species.sphere_radius_m;
}

struct Place {
  float x, z;
};

class Field {
 public:
  Field(std::span<const ScatterSpecies> species, const ScatterOptions& options) : species_(species), options_(options) {
    any_map_ = std::ranges::any_of(species, [](const ScatterSpecies& s) { return s.density != nullptr; });
  }

  float density(Place at, std::size_t s) const {
    const float map = species_[s].density != nullptr ? sample(*species_[s].density, at) : 1.0f;
    // Black is bare, so the noise is not needed.
    if (map <= 0.0f) return 0.0f;
    const float grove = map * std::exp(1.5f * noise(at.x / kGrove_m, at.z / kGrove_m, options_.seed * 131ull + s));
    if (any_map_) return grove;
    const float open = noise(at.x / kClearing_m, at.z / kClearing_m, options_.seed * 131ull + 0x10000) +
                       0.5f * noise(at.x / (0.4f * kClearing_m), at.z / (0.4f * kClearing_m), options_.seed * 131ull + 0x10001);
    return grove * std::clamp(0.8f + 1.2f * open, 0.02f, 1.5f);
  }

 private:
  float sample(const DensityMap& map, Place at) const {
    const auto texel = [](float share, std::uint32_t side) {
      return std::min(static_cast<std::uint32_t>(std::max(share, 0.0f) * static_cast<float>(side)), side - 1);
    };
    const std::uint32_t x = texel(at.x / options_.size_m + 0.5f, map.width), z = texel(at.z / options_.size_m + 0.5f, map.height);
    return static_cast<float>(map.grey[std::size_t{z} * map.width + x]) / 255.0f;
  }

  std::span<const ScatterSpecies> species_;
  const ScatterOptions& options_;
  bool any_map_ = false;
};

/// Plants by square cell. The scatter owns the plants.
class Stems {
 public:
  Stems(std::span<const ScatterSpecies> species, const ScatterOptions& options, const std::vector<ScenePlant>& plants)
      : species_(species), options_(options), plants_(plants) {
    for (const ScatterSpecies& s : species) largest_crown_m_ = std::max(largest_crown_m_, crown_radius_m(s) * options.scale_max);
    if (options.spacing <= 0.0f) return;
    constexpr float kMaxCells = 4096;
    cell_m_ = std::max(2.0f * options.spacing * largest_crown_m_, options.size_m / kMaxCells);
    side_ = static_cast<std::size_t>(options.size_m / cell_m_) + 1;
    first_.assign(side_ * side_, kNone);
    next_.reserve(static_cast<std::size_t>(options.count));
  }

  bool has_room(const ScenePlant& plant) const {
    if (first_.empty()) return true;
    const float crown_m = crown_of(plant);
    const float reach_m = options_.spacing * (crown_m + largest_crown_m_);
    for (std::size_t z = cell_of(plant.position_m[2] - reach_m); z <= cell_of(plant.position_m[2] + reach_m); ++z)
      for (std::size_t x = cell_of(plant.position_m[0] - reach_m); x <= cell_of(plant.position_m[0] + reach_m); ++x)
        for (std::uint32_t i = first_[z * side_ + x]; i != kNone; i = next_[i]) {
          const float dx = plants_[i].position_m[0] - plant.position_m[0], dz = plants_[i].position_m[2] - plant.position_m[2];
          const float spacing_m = options_.spacing * (crown_of(plants_[i]) + crown_m);
          if (dx * dx + dz * dz < spacing_m * spacing_m) return false;
        }
    return true;
  }
  /// Adds the plant that was last put into the array.
  void add() {
    if (first_.empty()) return;
    const ScenePlant& plant = plants_.back();
    std::uint32_t& first = first_[cell_of(plant.position_m[2]) * side_ + cell_of(plant.position_m[0])];
    next_.push_back(first);
    first = static_cast<std::uint32_t>(plants_.size() - 1);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  float crown_of(const ScenePlant& plant) const { return crown_radius_m(species_[plant.species]) * plant.scale; }
  std::size_t cell_of(float at) const {
    return std::min(static_cast<std::size_t>(std::max((at + 0.5f * options_.size_m) / cell_m_, 0.0f)), side_ - 1);
  }

  std::span<const ScatterSpecies> species_;
  const ScatterOptions& options_;
  const std::vector<ScenePlant>& plants_;
  float largest_crown_m_ = 0.0f, cell_m_ = 1.0f;
  std::size_t side_ = 0;
  std::vector<std::uint32_t> first_;  ///< [side_^2]; empty without spacing
  std::vector<std::uint32_t> next_;   ///< [plant]
};

class Scatter {
 public:
  Scatter(std::span<const ScatterSpecies> species, const ScatterOptions& options)
      : species_(species), options_(options), field_(species, options), stems_(species, options, plants_), placed_(species.size(), 0) {
    const double side = std::sqrt(static_cast<double>(options.count) / kPlantsAPlot);
    std::uint32_t plots = 1;
    while (plots < side && plots < kMaxPlots) plots *= 2;
    plot_side_ = plots;
    plot_m_ = options.size_m / static_cast<float>(plots);
    plants_.reserve(static_cast<std::size_t>(options.count));
  }

  Result<std::vector<ScenePlant>> run(const std::function<void(float)>& progress) {
    const std::vector<std::uint64_t> shares = scatter_shares(species_, options_.count);
    if (std::ranges::all_of(shares, [](std::uint64_t share) { return share == 0; }))
      return Error{Status::invalid_argument, "scatter: the density maps are black everywhere"};
    std::vector<std::size_t> by_crown(species_.size());
    std::iota(by_crown.begin(), by_crown.end(), std::size_t{0});
    std::ranges::stable_sort(by_crown, std::ranges::greater{}, [&](std::size_t s) { return species_[s].sphere_radius_m; });
    for (const std::size_t s : by_crown) place(s, shares[s], 0, progress);
    for (auto s = by_crown.rbegin(); s != by_crown.rend() && plants_.size() < options_.count; ++s)
      if (shares[*s] > 0 && placed_[*s] == shares[*s]) place(*s, options_.count - plants_.size(), kRounds, progress);
    if (plants_.size() == options_.count) return std::move(plants_);
    return Error{Status::invalid_argument, "scatter: no room for all plants; fewer of them, or less spacing", Error::kNoOffset,
                 std::to_string(plants_.size()) + " of " + std::to_string(options_.count) + " fit" + lack_text(shares)};
  }

 private:
  static constexpr std::uint64_t kRounds = 3;

  struct Plot {
    Place corner{};
    float density = 0.0f;      ///< mean
    float max_density = 0.0f;  ///< approximate
  };

  /// Places as many more plants of a species as fit, at most `wanted`. first_round  numbers the random places, which differ between rounds
  void place(std::size_t s, std::uint64_t wanted, std::uint64_t first_round, const std::function<void(float)>& progress) {
    if (wanted == 0) return;
    const std::vector<Plot> plots = measured_plots(s);
    const double total = std::accumulate(plots.begin(), plots.end(), 0.0, [](double sum, const Plot& plot) { return sum + plot.density; });
    if (!(total > 0.0)) return;
    const std::uint64_t end = plants_.size() + wanted;
    for (std::uint64_t round = first_round; round < first_round + kRounds && plants_.size() < end; ++round) {
      const std::uint64_t start = plants_.size(), missing = end - start;
      double density = 0.0;
      for (std::size_t i = 0; i < plots.size(); ++i) {
        density += plots[i].density;
        const auto target = start + static_cast<std::uint64_t>(std::llround(static_cast<double>(missing) * density / total));
        // Plants that did not fit into other plots may at most double a plot's number: if nothing fits anywhere, that must show soon.
        const auto share = static_cast<std::uint64_t>(2.0 * plots[i].density * static_cast<double>(wanted) / total);
        fill(plots[i], s, std::min({target, end, plants_.size() + share + 4}),
             mix_bits(options_.seed * 0x9e3779b97f4a7c15u + round + 16 * s) ^ i);
        if (progress && i % 64 == 0) progress(static_cast<float>(plants_.size()) / static_cast<float>(options_.count));
      }
    }
    placed_[s] += plants_.size() - (end - wanted);
  }

  std::vector<Plot> measured_plots(std::size_t s) const {
    constexpr int kSamples = 6;
    std::vector<Plot> plots;
    for (std::uint32_t code = 0; code < plot_side_ * plot_side_; ++code) {
      std::uint32_t x = 0, z = 0;
      for (std::uint32_t bit = 0; bit < 16; ++bit) {
        x |= (code >> 2 * bit & 1u) << bit;
        z |= (code >> (2 * bit + 1) & 1u) << bit;
      }
      Plot plot;
      plot.corner = {plot_m_ * static_cast<float>(x) - 0.5f * options_.size_m, plot_m_ * static_cast<float>(z) - 0.5f * options_.size_m};
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const auto share = [](int step) { return (static_cast<float>(step) + 0.5f) / kSamples; };
        const Place at{plot.corner.x + plot_m_ * share(i % kSamples), plot.corner.z + plot_m_ * share(i / kSamples)};
        const float density = field_.density(at, s);
        plot.density += density / (kSamples * kSamples);
        plot.max_density = std::max(plot.max_density, 1.2f * density);
      }
      plots.push_back(plot);
    }
    return plots;
  }

  void fill(const Plot& plot, std::size_t s, std::uint64_t target, std::uint64_t seed) {
    if (plants_.size() >= target || plot.density <= 0.0f) return;
    SeededRandom random(mix_bits(seed));
    const std::uint64_t attempts = kAttempts * (target - plants_.size());
    for (std::uint64_t i = 0; i < attempts && plants_.size() < target; ++i) {
      const Place at{plot.corner.x + plot_m_ * random.unit(), plot.corner.z + plot_m_ * random.unit()};
      if (random.unit() * plot.max_density >= field_.density(at, s)) continue;
      const ScenePlant plant = make_plant(at, s, random);
      if (!stems_.has_room(plant)) continue;
      plants_.push_back(plant);
      stems_.add();
    }
  }

  ScenePlant make_plant(Place at, std::size_t s, SeededRandom& random) const {
    ScenePlant plant;
    plant.position_m = {at.x, 0.0f, at.z};
    plant.species = static_cast<std::uint16_t>(s);
    plant.scale = std::lerp(options_.scale_min, options_.scale_max, random.unit());
    plant.yaw = static_cast<std::uint16_t>(random.unit() * 65535.0f);
    plant.mirrored = random.unit() < 0.5f;
    const float warm = 0.5f * (random.unit() - 0.5f) + 0.4f * noise(at.x / 13.0f, at.z / 13.0f, options_.seed + 7ull);
    const float light = 1.0f + 0.2f * (random.unit() - 0.5f);
    plant.tint = pack_tint({light * (1.0f + 0.25f * warm), light, light * (1.0f - 0.3f * warm)});
    return plant;
  }

  /// Says which species did not fit, and why.
  std::string lack_text(const std::vector<std::uint64_t>& shares) const {
    constexpr std::size_t kMaxSpecies = 6;
    std::string text;
    std::size_t lacking = 0;
    for (std::size_t s = 0; s < species_.size(); ++s) {
      if (placed_[s] >= shares[s] || ++lacking > kMaxSpecies) continue;
      std::array<char, 160> line{};
      std::snprintf(line.data(), line.size(), ": %llu of %llu, crowns %.3g m wide, so %.3g m apart at spacing %.3g",
                    static_cast<unsigned long long>(placed_[s]), static_cast<unsigned long long>(shares[s]),
                    static_cast<double>(2.0f * crown_radius_m(species_[s])),
                    static_cast<double>(2.0f * options_.spacing * crown_radius_m(species_[s])), static_cast<double>(options_.spacing));
      text += "; " + (species_[s].name.empty() ? "species " + std::to_string(s) : species_[s].name) + line.data();
    }
    std::array<char, 64> square{};
    std::snprintf(square.data(), square.size(), "; the square is %.6g m wide", static_cast<double>(options_.size_m));
    return text + square.data();
  }

  std::span<const ScatterSpecies> species_;
  const ScatterOptions& options_;
  Field field_;
  std::vector<ScenePlant> plants_;
  Stems stems_;
  std::vector<std::uint64_t> placed_;  ///< [species]
  std::uint32_t plot_side_ = 1;        ///< plots on each side; they lie along a Z-shaped curve
  float plot_m_ = 1.0f;
};

/// Mean density of a species; white is 1.
double mean_density(const ScatterSpecies& species) {
  if (species.density == nullptr) return 1.0;
  const std::vector<std::uint8_t>& grey = species.density->grey;
  return grey.empty() ? 0.0 : std::accumulate(grey.begin(), grey.end(), 0.0) / (255.0 * static_cast<double>(grey.size()));
}

}  // namespace

Result<DensityMap> decode_density_map(std::span<const std::uint8_t> bytes) {
  constexpr std::uint32_t kLargestSide_px = 16384;
  COPPICE_TRY(image, decode_image(bytes, kLargestSide_px));
  DensityMap map{image.width, image.height, std::vector<std::uint8_t>(std::size_t{image.width} * image.height)};
  for (std::size_t i = 0; i < map.grey.size(); ++i) {
    const std::uint8_t* texel = &image.rgba[4 * i];
    map.grey[i] = static_cast<std::uint8_t>((54 * texel[0] + 183 * texel[1] + 19 * texel[2] + 128) >> 8);
  }
  return map;
}

std::vector<std::uint64_t> scatter_shares(std::span<const ScatterSpecies> species, std::uint64_t count) {
  double all = 0.0, before = 0.0;
  for (const ScatterSpecies& each : species) all += mean_density(each);
  std::vector<std::uint64_t> shares;
  std::uint64_t given = 0;
  for (const ScatterSpecies& each : species) {
    before += mean_density(each);
    const auto until = all > 0.0 ? static_cast<std::uint64_t>(std::llround(static_cast<double>(count) * before / all)) : 0;
    shares.push_back(std::min(until, count) - given);
    given += shares.back();
  }
  return shares;
}

Result<std::vector<ScenePlant>> scatter_plants(std::span<const ScatterSpecies> species, const ScatterOptions& options,
                                               const std::function<void(float)>& progress) {
  if (species.empty() || options.count == 0 || options.count > 1u << 30 || !(options.size_m >= 1.0f) || options.size_m > 1e6f)
    return Error{Status::invalid_argument, "scatter: count, size or species out of range"};
  if (!(options.scale_min > 0.0f) || !(options.scale_max >= options.scale_min) || options.scale_max > 1e3f || !(options.spacing >= 0.0f))
    return Error{Status::invalid_argument, "scatter: scale or spacing out of range"};
  return Scatter(species, options).run(progress);
}

}  // namespace coppice::bake
