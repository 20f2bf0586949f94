#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "bounds.h"
#include "commands.h"
#include "coppice/format.h"
#include "inspect.h"
#include "output.h"
#include "printable.h"
#include "scene_reader.h"
#include "verify_scene.h"

namespace coppice::bake {
namespace {

using Json = nlohmann::ordered_json;

struct InspectArguments {
  std::filesystem::path input;
  bool json = false;
};

const char* metric_name(std::uint32_t metric) {
  switch (metric) {
    case COPPICE_METRIC_MI:
      return "mi";
    case COPPICE_METRIC_GEOMETRIC:
      return "geometric";
    case COPPICE_METRIC_IMAGE:
      return "image";
    default:
      return "unknown";
  }
}

void print_error_table(const FileSummary& file) {
  std::printf("\nerror table, px: size * rmse / 255 of a cut (row) at a projected size (column)\n%10s", "leaves");
  for (const float size : file.error_sizes_px) std::printf(" %8g", static_cast<double>(size));
  std::printf("\n");
  for (std::size_t level = 0; level < file.error_leaf_counts.size(); ++level) {
    std::printf("%10u", file.error_leaf_counts[level]);
    for (std::size_t size = 0; size < file.error_sizes_px.size(); ++size)
      std::printf(" %8.2f", static_cast<double>(file.error_px[level * file.error_sizes_px.size() + size]));
    std::printf("\n");
  }
  for (std::size_t i = 0; i < file.wood_error_px.size(); ++i) {
    const std::size_t sizes = file.error_sizes_px.size();
    if (i % sizes == 0) std::printf("%8s %zu", "wood", i / sizes);
    std::printf(" %8.2f%s", static_cast<double>(file.wood_error_px[i]), i % sizes + 1 == sizes ? "\n" : "");
  }
  if (file.leaf_mesh_error_px.empty()) return;
  std::printf("%10s", "as quads");
  for (const float error : file.leaf_mesh_error_px) std::printf(" %8.2f", static_cast<double>(error));
  std::printf("  all of them against the leaf meshes\n");
}

void print_leaf_meshes(const FileSummary& file) {
  if (file.leaf_meshes.empty()) {
    std::printf("no leaf meshes: nothing is finer than the quads\n");
    return;
  }
  std::uint64_t vertices = 0, triangles = 0, bytes = 0;
  for (const FileSummary::Mesh& mesh : file.leaf_meshes) vertices += mesh.vertices, triangles += mesh.triangles, bytes += mesh.bytes;
  std::printf("leaf meshes: %zu chunks, %llu triangles, %llu vertices, %s\n", file.leaf_meshes.size(),
              static_cast<unsigned long long>(triangles), static_cast<unsigned long long>(vertices), readable_bytes(bytes).c_str());
}

double cm(float length_m) {
  return 100.0 * static_cast<double>(length_m);
}

void print_wind(const WindSummary& wind) {
  if (wind.max_move_m == 0.0) {
    std::printf("wind: does not move it\n");
    return;
  }
  std::printf("wind, full: the stem bends %.1f cm, twigs lean %.1f cm more and sway %.1f cm; periods %.2f s and %.2f s; grid %u^3\n",
              cm(wind.head.bend_m), cm(wind.max_lean_m), cm(wind.max_sway_m), static_cast<double>(wind.head.stem_period_s),
              static_cast<double>(wind.head.branch_period_s), wind.head.node_side);
}

void print_text(const FileSummary& file) {
  std::printf("%s: %u leaves, metric %s, format version %u\n", printable(file.name).c_str(), file.leaf_count, metric_name(file.metric),
              file.version);
  std::printf("%s\n", size_text(file.size_m).c_str());
  std::printf("%s in all, %s for a first picture, foliage %.1f B/leaf\n\n", readable_bytes(file.file_bytes).c_str(),
              readable_bytes(file.first_read_bytes).c_str(), file.bytes_per_leaf);
  std::printf("%-10s %6s %12s\n", "chunks", "count", "bytes");
  for (const ChunkSummary& chunk : file.chunks)
    std::printf("%-10s %6u %12llu%s%s\n", chunk.kind, chunk.count, static_cast<unsigned long long>(chunk.bytes),
                *chunk.draco == 0 ? "" : "  Draco ", chunk.draco);
  for (std::size_t lod = 0; lod < file.wood.size(); ++lod)
    std::printf("%s%zu: %u triangles, %s", lod == 0 ? "\nwood LoD " : "; ", lod, file.wood[lod].triangles,
                readable_bytes(file.wood[lod].bytes).c_str());
  if (!file.wood.empty()) std::printf("\n");
  for (std::size_t texture = 0; texture < file.textures.size(); ++texture)
    std::printf("texture %zu: %s, %u x %u, %u mips, %s\n", texture, file.textures[texture].format, file.textures[texture].width,
                file.textures[texture].height, file.textures[texture].mip_count, readable_bytes(file.textures[texture].bytes).c_str());
  print_leaf_meshes(file);
  print_wind(file.wind);
  print_error_table(file);
}

void print_json(const FileSummary& file) {
  Json chunks = Json::array(), wood = Json::array(), textures = Json::array(), leaf_meshes = Json::array();
  for (const auto& mesh : file.leaf_meshes)
    leaf_meshes.push_back({{"vertices", mesh.vertices}, {"triangles", mesh.triangles}, {"bytes", mesh.bytes}});
  for (const auto& chunk : file.chunks) {
    chunks.push_back({{"kind", chunk.kind}, {"count", chunk.count}, {"bytes", chunk.bytes}});
    if (*chunk.draco != 0) chunks.back()["draco"] = chunk.draco;
  }
  for (const auto& lod : file.wood) wood.push_back({{"vertices", lod.vertices}, {"triangles", lod.triangles}, {"bytes", lod.bytes}});
  for (const auto& texture : file.textures)
    textures.push_back({{"format", texture.format},
                        {"width", texture.width},
                        {"height", texture.height},
                        {"mips", texture.mip_count},
                        {"bytes", texture.bytes}});
  const Json json = {
      {"name", file.name},
      {"version", file.version},
      {"metric", metric_name(file.metric)},
      {"leaves", file.leaf_count},
      {"size_m", file.size_m},
      {"pages", file.page_count},
      {"materials", file.material_count},
      {"cards", file.card_count},
      {"file_bytes", file.file_bytes},
      {"first_read_bytes", file.first_read_bytes},
      {"bytes_per_leaf", file.bytes_per_leaf},
      {"chunks", chunks},
      {"wood", wood},
      {"textures", textures},
      {"leaf_meshes", leaf_meshes},
      {"wind",
       {{"base_y_m", file.wind.head.base_y_m},
        {"height_m", file.wind.head.height_m},
        {"bend_m", file.wind.head.bend_m},
        {"lean_m", file.wind.max_lean_m},
        {"sway_m", file.wind.max_sway_m},
        {"stem_period_s", file.wind.head.stem_period_s},
        {"branch_period_s", file.wind.head.branch_period_s},
        {"node_side", file.wind.head.node_side},
        {"most_move_m", file.wind.max_move_m},
        {"most_growth", file.wind.max_growth}}},
      {"wood_error_px", file.wood_error_px},
      {"leaf_mesh_error_px", file.leaf_mesh_error_px},
      {"error_table", {{"leaves", file.error_leaf_counts}, {"sizes_px", file.error_sizes_px}, {"error_px", file.error_px}}},
  };
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

std::uint32_t level_count(const SceneFile& scene) {
  std::uint32_t count = 0;
  for (const SceneTile& tile : scene.tiles) count = std::max(count, tile.level + 1);
  return count;
}

void print_scene_text(const InspectArguments& arguments, const SceneFile& scene) {
  std::printf("%s: %llu plants of %zu species, format version %u, %s\n", shown(arguments.input).c_str(),
              static_cast<unsigned long long>(scene.header.instance_count), scene.species.size(), scene.header.version,
              readable_bytes(scene.header.file_bytes).c_str());
  const SceneTile& root = scene.tiles[0];
  std::printf("%.0f m x %.0f m from x %.0f, z %.0f; feet %.1f m to %.1f m high; %zu tiles in %u levels\n\n", double{root.square_side_m},
              double{root.square_side_m}, double{root.square_min_m[0]}, double{root.square_min_m[1]}, double{scene.height_min_m},
              double{scene.height_max_m}, scene.tiles.size(), level_count(scene));
  std::printf("%10s  %s\n", "radius, m", "species");
  for (const SceneFileSpecies& species : scene.species)
    std::printf("%10.2f  %s\n", double{species.sphere_radius_m}, printable(species.path).c_str());
}

void print_scene_json(const SceneFile& scene) {
  Json species = Json::array();
  for (const SceneFileSpecies& one : scene.species)
    species.push_back({{"path", std::string(one.path)}, {"sphere_radius_m", one.sphere_radius_m}});
  const Json json = {{"version", scene.header.version},
                     {"plants", scene.header.instance_count},
                     {"file_bytes", scene.header.file_bytes},
                     {"square_min_m", scene.tiles[0].square_min_m},
                     {"square_side_m", scene.tiles[0].square_side_m},
                     {"height_min_m", scene.height_min_m},
                     {"height_max_m", scene.height_max_m},
                     {"tiles", scene.tiles.size()},
                     {"levels", level_count(scene)},
                     {"species", species}};
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

int run_scene(const InspectArguments& arguments, std::span<const std::uint8_t> bytes) {
  const auto scene = read_scene_front(bytes, bytes.size());
  if (!scene) return report_failure(arguments.input, scene.error());
  if (arguments.json)
    print_scene_json(*scene);
  else
    print_scene_text(arguments, *scene);
  return 0;
}

int run(const InspectArguments& arguments) {
  const auto bytes = read_file(arguments.input);
  if (!bytes) return report_failure(arguments.input, bytes.error());
  if (is_scene(*bytes)) return run_scene(arguments, *bytes);
  const auto summary = inspect(*bytes);
  if (!summary) return report_failure(arguments.input, summary.error());
  if (arguments.json)
    print_json(*summary);
  else
    print_text(*summary);
  return 0;
}

}  // namespace

void add_inspect_command(CLI::App& app, int* exit_code) {
  auto arguments = std::make_shared<InspectArguments>();
  CLI::App* command = app.add_subcommand("inspect",
                                         "Show what is inside a .coppice file: sizes per kind of chunk and what Draco codes of it, wood "
                                         "LoDs, error table; or a .forest file: plants, tiles, species");
  command->add_option("input", arguments->input, "A .coppice or a .forest file")->required()->type_name("IN.coppice|IN.forest");
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([arguments, exit_code] { *exit_code = run(*arguments); });
}

}  // namespace coppice::bake
