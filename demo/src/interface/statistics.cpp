#include "statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "output.h"

namespace forest {
namespace {

constexpr std::array<const char*, COPPICE_STREAMED_ALL> kStreamedNames = {"pages", "wood", "textures", "leaf_meshes"};

template <class T>
T nearest_rank(std::vector<T> values, double share) {
  if (values.empty()) return T{};
  std::ranges::sort(values);
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<std::size_t>(rank, 1) - 1];
}

template <class... Values>
std::string line(const char* format, Values... values) {
  char text[160];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

double mebibytes(std::uint64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

double bytes_per_s(const Statistics& statistics) {
  return statistics.seconds > 0 ? static_cast<double>(statistics.last.bytes_read) / statistics.seconds : 0;
}

}  // namespace

FrameTimes summarize(const std::vector<float>& frame_ms) {
  FrameTimes times;
  times.median = nearest_rank(frame_ms, 0.5);
  times.p95 = nearest_rank(frame_ms, 0.95);
  times.p99 = nearest_rank(frame_ms, 0.99);
  times.max = nearest_rank(frame_ms, 1);
  return times;
}

std::string table(const Statistics& statistics) {
  const FrameTimes times = summarize(statistics.frame_ms);
  const coppice_stats& last = statistics.last;
  const std::uint64_t leaves = nearest_rank(statistics.drawn_leaves, 0.5);
  const double share = last.source_leaf_count ? 100 * static_cast<double>(leaves) / static_cast<double>(last.source_leaf_count) : 0;
  std::string text;
  text += line("device               %s\n", statistics.device.c_str());
  text += line("frame size           %u x %u, drawn at %u x %u, %s shadow maps, %s temporal antialiasing\n", statistics.picture_px[0],
               statistics.picture_px[1], statistics.drawn_px[0], statistics.drawn_px[1], statistics.shadow_maps ? "with" : "without",
               statistics.temporal ? "with" : "without");
  text += line("frames               %zu\n", statistics.frame_ms.size());
  text += line("frame time           median %.1f ms, p95 %.1f, p99 %.1f, max %.1f\n", double{times.median}, double{times.p95},
               double{times.p99}, double{times.max});
  text += line("plants               %u: %u visible, %u hidden by others, %u out of view (medians)\n", last.instance_count,
               nearest_rank(statistics.visible_instances, 0.5), nearest_rank(statistics.occluded_instances, 0.5),
               nearest_rank(statistics.culled_instances, 0.5));
  text += line("leaves               %llu drawn (median) of %llu in the scene (%.2f %%)\n", static_cast<unsigned long long>(leaves),
               static_cast<unsigned long long>(last.source_leaf_count), share);
  text += line("close up             %u plants drawn with leaf meshes (median), %llu triangles\n",
               nearest_rank(statistics.leaf_mesh_instances, 0.5),
               static_cast<unsigned long long>(nearest_rank(statistics.leaf_mesh_triangles, 0.5)));
  text += line("wood                 %llu triangles drawn (median)\n",
               static_cast<unsigned long long>(nearest_rank(statistics.drawn_wood_triangles, 0.5)));
  text += line("error threshold      %.2f px (median)\n", double{nearest_rank(statistics.threshold_px, 0.5)});
  if (!statistics.pass_ms[0].empty()) {
    text += "passes, ms           ";
    for (std::size_t i = 0; i < kPassNames.size(); ++i)
      text += line("%s%s %.2f", i > 0 ? ", " : "", kPassNames[i], double{nearest_rank(statistics.pass_ms[i], 0.5)});
    text += "\n";
  }
  text += line("memory               peak %.1f MiB of %.1f\n", mebibytes(last.memory_peak_bytes), mebibytes(last.memory_budget_bytes));
  if (last.scene_tile_count > 0)
    text += line("scene                %u of %u tiles resident, %u missing, %u failed, threshold %.1f px; settled after %.0f ms\n",
                 last.scene_tiles_resident, last.scene_tile_count, last.scene_tiles_missing, last.scene_tiles_failed,
                 double{last.scene_threshold_px}, double{statistics.settled_ms});
  if (statistics.first_picture_ms > 0) text += line("first picture        %.0f ms\n", double{statistics.first_picture_ms});
  for (std::size_t kind = 0; kind < kStreamedNames.size(); ++kind) {
    const coppice_streamed_stats& of = last.streamed[kind];
    if (of.loaded + of.failed + of.cancelled == 0) continue;
    text += line("%-20s %llu loaded, %llu evicted, %llu cancelled, %llu failed\n", kStreamedNames[kind],
                 static_cast<unsigned long long>(of.loaded), static_cast<unsigned long long>(of.evicted),
                 static_cast<unsigned long long>(of.cancelled), static_cast<unsigned long long>(of.failed));
  }
  text += line("streaming            threshold at most %.2f px; %.1f MB read, %.1f MB/s; %.0f ms of decoding\n",
               double{statistics.max_threshold_px}, 1e-6 * static_cast<double>(last.bytes_read), 1e-6 * bytes_per_s(statistics),
               last.decode_ms);
  text += line("errors               %u\n", statistics.errors);
  text += line("validation messages  %u\n", statistics.validation_messages);
  return text;
}

void write_json(const std::string& file, const Statistics& statistics) {
  const FrameTimes times = summarize(statistics.frame_ms);
  const coppice_stats& last = statistics.last;
  nlohmann::ordered_json json;
  json["device"] = statistics.device;
  json["driver"] = statistics.driver;
  json["software_device"] = statistics.software_device;
  json["picture_px"] = statistics.picture_px;
  json["drawn_px"] = statistics.drawn_px;
  json["shadow_maps"] = statistics.shadow_maps;
  json["temporal"] = statistics.temporal;
  json["frames"] = statistics.frame_ms.size();
  json["frame_ms"] = {{"median", times.median}, {"p95", times.p95}, {"p99", times.p99}, {"max", times.max}};
  json["instances"] = last.instance_count;
  json["visible_instances_median"] = nearest_rank(statistics.visible_instances, 0.5);
  json["occluded_instances_median"] = nearest_rank(statistics.occluded_instances, 0.5);
  json["culled_instances_median"] = nearest_rank(statistics.culled_instances, 0.5);
  json["source_leaves_in_scene"] = last.source_leaf_count;
  json["drawn_leaves_median"] = nearest_rank(statistics.drawn_leaves, 0.5);
  json["leaf_mesh_instances_median"] = nearest_rank(statistics.leaf_mesh_instances, 0.5);
  json["leaf_mesh_triangles_median"] = nearest_rank(statistics.leaf_mesh_triangles, 0.5);
  json["drawn_wood_triangles_median"] = nearest_rank(statistics.drawn_wood_triangles, 0.5);
  json["threshold_px_median"] = nearest_rank(statistics.threshold_px, 0.5);
  if (!statistics.pass_ms[0].empty())
    for (std::size_t i = 0; i < kPassNames.size(); ++i) json["pass_ms"][kPassNames[i]] = nearest_rank(statistics.pass_ms[i], 0.5);
  json["memory_budget_bytes"] = last.memory_budget_bytes;
  json["memory_peak_bytes"] = last.memory_peak_bytes;
  json["device_allocations"] = last.device_allocations;
  json["pages_loaded"] = last.streamed[COPPICE_STREAMED_PAGES].loaded;
  json["pages_evicted"] = last.streamed[COPPICE_STREAMED_PAGES].evicted;
  for (std::size_t kind = 0; kind < kStreamedNames.size(); ++kind) {
    const coppice_streamed_stats& of = last.streamed[kind];
    json["streamed"][kStreamedNames[kind]] = {
        {"loaded", of.loaded}, {"evicted", of.evicted}, {"cancelled", of.cancelled}, {"failed", of.failed}};
  }
  if (statistics.first_picture_ms > 0) json["first_picture_ms"] = statistics.first_picture_ms;
  if (last.scene_tile_count > 0)
    json["scene"] = {{"instances", last.scene_instance_count},      {"tiles", last.scene_tile_count},
                     {"tiles_resident", last.scene_tiles_resident}, {"tiles_missing", last.scene_tiles_missing},
                     {"tiles_failed", last.scene_tiles_failed},     {"species_failed", last.scene_species_failed},
                     {"threshold_px", last.scene_threshold_px},     {"settled_ms", statistics.settled_ms}};
  json["chunks_in_flight_max"] = statistics.max_chunks_in_flight;
  json["chunks_queued_max"] = statistics.max_chunks_queued;
  json["bytes_read"] = last.bytes_read;
  json["bytes_per_s"] = bytes_per_s(statistics);
  json["decode_ms"] = last.decode_ms;
  json["threshold_px_max"] = statistics.max_threshold_px;
  json["errors"] = statistics.errors;
  json["validation_messages"] = statistics.validation_messages;
  write_output(file, json.dump(2) + '\n');
}

}  // namespace forest
