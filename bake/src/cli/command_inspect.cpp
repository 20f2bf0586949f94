#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "atomic_file.h"
#include "commands.h"
#include "coppice/format.h"
#include "inspect.h"
#include "plant_size.h"
#include "printable.h"

namespace coppice::bake {
namespace {

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
  for (const FileSummary::LeafMesh& mesh : file.leaf_meshes) vertices += mesh.vertices, triangles += mesh.triangles, bytes += mesh.bytes;
  std::printf("leaf meshes: %zu chunks, %llu triangles, %llu vertices, %s\n", file.leaf_meshes.size(),
              static_cast<unsigned long long>(triangles), static_cast<unsigned long long>(vertices), readable_bytes(bytes).c_str());
}

void print_text(const FileSummary& file) {
  std::printf("%s: %u leaves, metric %s, format version %u\n", printable(file.name).c_str(), file.leaf_count, metric_name(file.metric),
              file.version);
  std::printf("%s\n", size_text(file.size_m).c_str());
  std::printf("%s in all, %s for a first picture, foliage %.1f B/leaf\n\n", readable_bytes(file.file_bytes).c_str(),
              readable_bytes(file.first_read_bytes).c_str(), file.bytes_per_leaf);
  std::printf("%-10s %6s %12s\n", "chunks", "count", "bytes");
  for (const ChunkSummary& chunk : file.chunks)
    std::printf("%-10s %6u %12llu\n", chunk.kind, chunk.count, static_cast<unsigned long long>(chunk.bytes));
  for (std::size_t lod = 0; lod < file.wood.size(); ++lod)
    std::printf("%s%zu: %u triangles, %s", lod == 0 ? "\nwood LoD " : "; ", lod, file.wood[lod].triangles,
                readable_bytes(file.wood[lod].bytes).c_str());
  if (!file.wood.empty()) std::printf("\n");
  for (std::size_t texture = 0; texture < file.textures.size(); ++texture)
    std::printf("texture %zu: %s, %u x %u, %u mips, %s\n", texture, file.textures[texture].format, file.textures[texture].width,
                file.textures[texture].height, file.textures[texture].mip_count, readable_bytes(file.textures[texture].bytes).c_str());
  print_leaf_meshes(file);
  print_error_table(file);
}

void print_json(const FileSummary& file) {
  using Json = nlohmann::ordered_json;
  Json chunks = Json::array(), wood = Json::array(), textures = Json::array(), leaf_meshes = Json::array();
  for (const auto& mesh : file.leaf_meshes)
    leaf_meshes.push_back({{"vertices", mesh.vertices}, {"triangles", mesh.triangles}, {"bytes", mesh.bytes}});
  for (const auto& chunk : file.chunks) chunks.push_back({{"kind", chunk.kind}, {"count", chunk.count}, {"bytes", chunk.bytes}});
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
      {"wood_error_px", file.wood_error_px},
      {"leaf_mesh_error_px", file.leaf_mesh_error_px},
      {"error_table", {{"leaves", file.error_leaf_counts}, {"sizes_px", file.error_sizes_px}, {"error_px", file.error_px}}},
  };
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

}  // namespace

void add_inspect_command(CLI::App& app, int* exit_code) {
  struct Arguments {
    std::filesystem::path input;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("inspect", "Show what is inside a .coppice file: sizes per kind of chunk, wood LoDs, error table");
  command->add_option("input", arguments->input, "A .coppice file")->required();
  command->add_flag("--json", arguments->json, "As JSON");
  command->callback([arguments, exit_code] {
    const auto bytes = read_file(arguments->input);
    if (!bytes) {
      *exit_code = report_failure(arguments->input, bytes.error());
      return;
    }
    const auto summary = inspect(*bytes);
    if (!summary)
      *exit_code = report_failure(arguments->input, summary.error());
    else if (arguments->json)
      print_json(*summary);
    else
      print_text(*summary);
  });
}

}  // namespace coppice::bake
