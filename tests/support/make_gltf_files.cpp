// make_gltf_files bad FOLDER     writes the files of tests/data/bad/gltf, and expected.txt with what is to be named of each
// make_gltf_files corpus FOLDER  writes tests/fuzz/corpus/import: one small plant for each form that the importer reads

#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "bad_gltf.h"
#include "gltf_builder.h"
#include "gltf_compress.h"

namespace {

using coppice::test::GltfBuilder;
using nlohmann::json;
namespace test = coppice::test;

void write_bad(const std::filesystem::path& folder) {
  std::ofstream expected(folder / "expected.txt");
  expected.exceptions(std::ios::failbit | std::ios::badbit);
  for (const test::BadGltf& bad : test::bad_gltf_files()) {
    test::write_file(folder / bad.file, bad.bytes);
    expected << bad.file << '|' << static_cast<int>(bad.status);
    for (const std::string& name : bad.names) expected << '|' << name;
    expected << '\n';
  }
}

GltfBuilder draco_plant(bool edgebreaker) {
  GltfBuilder builder = test::small_plant();
  test::DracoMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {3, 0, 1}, {3, 1, 1}, {2, 1, 0}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  mesh.edgebreaker = edgebreaker;
  mesh.position_bits = edgebreaker ? 11 : 0;
  json& primitive = builder.json["meshes"][0]["primitives"][0];
  primitive["attributes"]["TEXCOORD_0"] = 0;
  test::add_draco(builder, primitive, test::encode_draco(mesh), {{"POSITION", 0}, {"TEXCOORD_0", 1}});
  return builder;
}

GltfBuilder meshopt_plant(const std::string& index_mode) {
  GltfBuilder builder = test::small_plant();
  test::compress_view(builder, 0, {.stride = 12});
  test::compress_view(builder, 1, {.mode = index_mode, .stride = 2});
  const int normals = builder.add_view(std::vector<std::uint8_t>(16, 0), 4);
  builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = builder.add_accessor(normals, test::kByte, "VEC3", 4, true);
  test::compress_view(builder, normals, {.filter = "OCTAHEDRAL", .stride = 4});
  const int rotations = builder.add_view(std::vector<std::uint8_t>(16, 3), 8),
            moves = builder.add_view(std::vector<std::uint8_t>(24, 1), 12);
  builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", builder.add_accessor(rotations, test::kShort, "VEC4", 2, true)},
      {"TRANSLATION", builder.add_accessor(moves, test::kFloat, "VEC3", 2)}};
  test::compress_view(builder, rotations, {.filter = "QUATERNION", .stride = 8});
  test::compress_view(builder, moves, {.filter = "EXPONENTIAL", .stride = 12});
  return builder;
}

GltfBuilder textured_plant() {
  GltfBuilder builder = test::small_plant();
  builder.set_texture(0, test::png(2, 2, {10, 200, 30, 128}));
  json& texture = builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
  texture["extensions"]["KHR_texture_transform"] = {{"offset", {0.5, 0}}, {"rotation", 0.5}, {"scale", {2, 2}}, {"texCoord", 1}};
  builder.json["images"].push_back({{"bufferView", builder.add_view(test::webp(2, 2, {0, 0, 255, 255}))}});
  builder.json["textures"][0]["extensions"]["EXT_texture_webp"]["source"] = 1;
  json& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_1"] = builder.add_uvs({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  const int colors = builder.add_view(std::vector<std::uint8_t>{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0, 9, 9, 9, 9});
  attributes["COLOR_0"] = builder.add_accessor(colors, test::kUnsignedByte, "VEC4", 4, true);
  builder.json["materials"][0].update({{"alphaMode", "MASK"}, {"doubleSided", true}});
  return builder;
}

GltfBuilder nested_plant() {
  GltfBuilder builder = test::small_plant();
  builder.json["nodes"].push_back({{"children", {1}}, {"scale", {-1, 2, 1}}, {"rotation", {0, 0.6, 0, 0.8}}});
  builder.json["scenes"][0]["nodes"] = {0, 2};
  const int indices = builder.add_view(std::vector<std::uint8_t>{1});
  const int values = builder.add_view(std::vector<float>{2.0f, 0.0f, 0.0f});
  builder.json["accessors"][2]["sparse"] = {
      {"count", 1}, {"indices", {{"bufferView", indices}, {"componentType", test::kUnsignedByte}}}, {"values", {{"bufferView", values}}}};
  const int shorts = builder.add_view(std::vector<std::int16_t>{0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0, 9, 9, 0, 0}, 8);
  const int positions = builder.add_accessor(shorts, test::kShort, "VEC3", 4);
  for (const int mode : {5, 6}) builder.add_node(builder.add_mesh({{"POSITION", positions}}, std::nullopt, 0, mode));
  return builder;
}

GltfBuilder lines_plant() {
  GltfBuilder builder = test::small_plant();
  const int points = builder.add_positions({{0, 0, 0}, {0, 1, 0}, {0, 2, 0.5}, {1, 2, 0}, {0, 2, 0.5}, {0, 3, 1}});
  for (const int mode : {1, 2, 3}) builder.add_node(builder.add_mesh({{"POSITION", points}, {"COLOR_0", points}}, std::nullopt, 0, mode));
  return builder;
}

void write_corpus(const std::filesystem::path& folder) {
  const std::vector<std::pair<const char*, GltfBuilder>> plants{{"small", test::small_plant()},
                                                                {"draco_edgebreaker", draco_plant(true)},
                                                                {"draco_sequential", draco_plant(false)},
                                                                {"meshopt_triangles", meshopt_plant("TRIANGLES")},
                                                                {"meshopt_indices", meshopt_plant("INDICES")},
                                                                {"lines", lines_plant()},
                                                                {"textured", textured_plant()},
                                                                {"nested", nested_plant()}};
  for (const auto& [name, builder] : plants) test::write_file(folder / (std::string(name) + ".glb"), builder.glb());
  test::write_file(folder / "text.gltf", textured_plant().gltf());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[1] : "";
  if (what != "bad" && what != "corpus") {
    std::fprintf(stderr, "usage: make_gltf_files bad|corpus FOLDER\n");
    return 2;
  }
  try {
    std::filesystem::create_directories(argv[2]);
    what == "bad" ? write_bad(argv[2]) : write_corpus(argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_gltf_files: %s: %s\n", argv[2], error.what());
    return 1;
  }
  return 0;
}
