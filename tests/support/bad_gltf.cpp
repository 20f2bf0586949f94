#include "bad_gltf.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>

#include "encoded_images.h"
#include "gltf_builder.h"
#include "gltf_compress.h"

namespace coppice::test {
namespace {

using nlohmann::json;
using GltfBytes = std::vector<std::uint8_t>;
using Names = std::vector<std::string>;

GltfBytes text(const std::string& characters) {
  return {characters.begin(), characters.end()};
}

/// The files, as they are made.
class Collection {
 public:
  void add(const std::string& file, GltfBytes bytes, Names names, Status status = Status::bad_file) {
    files_.push_back({file, std::move(bytes), std::move(names), status});
  }

  /// The small plant with one thing changed, as text with its buffer inside.
  void change(const std::string& name, const std::function<void(GltfBuilder&)>& edit, Names names, Status status = Status::bad_file) {
    GltfBuilder builder = small_plant();
    edit(builder);
    add(name + ".gltf", builder.gltf(), std::move(names), status);
  }
  void change_json(const std::string& name, const std::function<void(json&)>& edit, Names names, Status status = Status::bad_file) {
    change(
        name, [&](GltfBuilder& builder) { edit(builder.json); }, std::move(names), status);
  }

  std::vector<BadGltf> sorted() {
    std::sort(files_.begin(), files_.end(), [](const BadGltf& a, const BadGltf& b) { return a.file < b.file; });
    return std::move(files_);
  }

 private:
  std::vector<BadGltf> files_;
};

json& primitive(json& document, std::size_t mesh = 0) {
  return document["meshes"][mesh]["primitives"][0];
}

void add_containers(Collection& files) {
  const GltfBytes good = small_plant().glb();
  const auto changed = [&](std::size_t at, std::uint8_t value) {
    GltfBytes bytes = good;
    bytes[at] = value;
    return bytes;
  };
  files.add("glb_empty.glb", {}, {});
  files.add("glb_header_only.glb", GltfBytes(good.begin(), good.begin() + 12), {"byte 12"});
  files.add("glb_cut.glb", GltfBytes(good.begin(), good.end() - 10), {"796", "786", "byte 8"});
  files.add("glb_version.glb", changed(4, 1), {"byte 4"}, Status::unsupported);
  files.add("glb_chunk_long.glb", changed(15, 0x7f), {"byte 12"});
  files.add("glb_chunk_kind.glb", changed(16, 'X'), {"JSON", "byte 16"});
  files.add("json_none.gltf", text("Dear diary, today I planted a hazel.\n"), {"glTF"});
  files.add("json_cut.gltf", text(R"({"asset": {"version": "2.0"}, "meshes": [)"), {"JSON", "byte 42"});
  files.add("json_deep.gltf", text(R"({"asset": {"version": "2.0"}, "extras": )" + std::string(100, '[')), {"JSON", "64", "byte 103"});
  files.change_json(
      "asset_version", [](json& j) { j["asset"]["version"] = "1.0"; }, {"asset.version", "1.0"}, Status::unsupported);
  files.change_json(
      "required_unknown", [](json& j) { j["extensionsRequired"] = {"EXT_made_up"}; }, {"extensionsRequired", "EXT_made_up"},
      Status::unsupported);
  files.change_json(
      "required_basisu",
      [](json& j) {
        j["extensionsRequired"] = {"KHR_texture_basisu"};
        j["textures"] = {{{"extensions", {{"KHR_texture_basisu", {{"source", 0}}}}}}};
      },
      {"KTX2", "textures[0].extensions.KHR_texture_basisu"}, Status::unsupported);
}

void add_buffers(Collection& files) {
  const auto buffer = [&files](const std::string& name, std::size_t bytes, const std::string& uri, Names names,
                               Status status = Status::bad_file) {
    files.change_json(
        name,
        [&](json& j) {
          j["buffers"] = {{{"byteLength", bytes}, {"uri", uri}}};
        },
        std::move(names), status);
  };
  buffer("buffer_missing", 96, "not_there.bin", {"buffers[0].uri", "not_there.bin"}, Status::io);
  buffer("buffer_short", 96, "data:application/octet-stream;base64,AAAA", {"buffers[0].uri"}, Status::io);
  buffer("buffer_not_base64", 96, "data:application/octet-stream;base64,!!!!", {"buffers[0].uri"}, Status::io);
  buffer("buffer_of_nothing", 0, "x.bin", {"buffers[0].byteLength"});
  files.change_json("view_past_buffer", [](json& j) { j["bufferViews"][0]["byteLength"] = 99999; }, {"bufferViews[0]", "99999"});
  files.change_json("view_offset_wraps", [](json& j) { j["bufferViews"][0]["byteOffset"] = 18446744073709551612ull; },
                    {"bufferViews[0]", "18446744073709551612"});
  files.change_json("accessor_past_view", [](json& j) { j["accessors"][0]["count"] = 5; }, {"accessors[0]", "5"});
  files.change_json("accessor_billion", [](json& j) { j["accessors"][0]["count"] = 1000000000; }, {"accessors[0]", "1000000000"});
  files.change_json("accessor_billion_of_nothing",
                    [](json& j) {
                      j["accessors"][0].erase("bufferView");
                      j["accessors"][0]["count"] = 1000000000;
                    },
                    {"accessors[0].count", "1000000000"});
  files.change_json("accessor_component", [](json& j) { j["accessors"][0]["componentType"] = 5124; },
                    {"accessors[0].componentType", "5124"});
  files.change_json("accessor_shape", [](json& j) { j["accessors"][0]["type"] = "VEC2"; },
                    {"VEC3", "meshes[0].primitives[0]", "accessors[0]"});
  files.change_json(
      "image_missing",
      [](json& j) {
        j["images"] = {{{"uri", "not_there.png"}}};
        j["textures"] = {{{"source", 0}}};
        j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
      },
      {"images[0].uri", "not_there.png"}, Status::io);
  for (const auto& [name, uri] : std::initializer_list<std::pair<std::string, std::string>>{{"absolute", "/etc/passwd"},
                                                                                            {"above", "../../../../../../../../etc/passwd"},
                                                                                            {"escaped", "..%2f..%2fexpected.txt"},
                                                                                            {"scheme", "file:///etc/passwd"}}) {
    buffer("buffer_outside_" + name, 96, uri, {"--allow-outside", "buffers[0].uri", uri}, Status::invalid_argument);
    files.change_json(
        "image_outside_" + name,
        [path = uri](json& j) {
          j["images"] = {{{"uri", path}}};
        },
        {"--allow-outside", "images[0].uri", uri}, Status::invalid_argument);
  }
  files.change("image_cut",
               [](GltfBuilder& builder) {
                 GltfBytes image = png(16, 16, {10, 200, 30, 255});
                 image.resize(image.size() - 20);
                 builder.set_texture(0, image);
               },
               {"images[0]"});
  files.change("image_without_scan", [](GltfBuilder& builder) { builder.set_texture(0, jpeg_without_scan()); }, {"images[0]"});
  files.change("image_inflating",
               [](GltfBuilder& builder) {
                 const GltfBytes large =
                     encode_png_form({.width = 8192, .height = 8192, .bit_depth = 1, .color_type = 0, .rows = GltfBytes(8192 * 1024)});
                 builder.set_texture(0, with_png_chunk(large, "IHDR", 0, {0, 0, 0, 1, 0, 0, 0, 1}));
               },
               {"images[0]"});
}

void add_geometry(Collection& files) {
  for (const auto& [name, value] : {std::pair{"position_nan", std::nanf("")}, std::pair{"position_infinite", INFINITY}})
    files.change(name, [number = value](GltfBuilder& builder) { std::memcpy(&builder.bin[20], &number, sizeof number); },
                 {"meshes[0].primitives[0]", "accessors[0] element 1"});
  files.change_json("position_far", [](json& j) { j["nodes"][0]["scale"] = {1e300, 1e300, 1e300}; }, {"1e8", "nodes[0]"});
  files.change("index_beyond", [](GltfBuilder& builder) { builder.bin[48 + 2 * 4] = 4; },
               {"meshes[0].primitives[0]", "accessors[1] element 4"});
  files.change_json("index_float",
                    [](json& j) {
                      j["accessors"][1].update({{"componentType", kFloat}, {"count", 3}});
                    },
                    {"indices", "meshes[0].primitives[0]", "accessors[1]"});
  files.change_json("sparse_beyond",
                    [](json& j) {
                      const json part{{"bufferView", 0}, {"componentType", kUnsignedShort}, {"byteOffset", 14}};
                      j["accessors"][0]["sparse"] = {{"count", 1}, {"indices", part}, {"values", {{"bufferView", 0}}}};
                    },
                    {"sparse", "meshes[0].primitives[0]", "accessors[0]"});
  files.change_json("attributes_unequal", [](json& j) { primitive(j)["attributes"]["NORMAL"] = 2; },
                    {"meshes[0].primitives[0]", "NORMAL", "3", "POSITION", "4"});
  files.change("color_shape",
               [](GltfBuilder& builder) {
                 primitive(builder.json, 1)["attributes"]["COLOR_0"] = builder.add_uvs({{0, 0}, {0, 0}, {0, 0}});
               },
               {"VEC3", "meshes[1].primitives[0]", "accessors[3]"});
  files.change("leaf_of_one_point",
               [](GltfBuilder& builder) {
                 builder.json["scenes"][0]["nodes"] = {0};
                 primitive(builder.json)["attributes"]["POSITION"] = builder.add_positions(std::vector<glm::vec3>(4, glm::vec3(1.0f)));
               },
               {"'leaves'"});
  files.change_json("points_only",
                    [](json& j) {
                      primitive(j, 0)["mode"] = 0;
                      primitive(j, 1)["mode"] = 0;
                    },
                    {});
}

void add_nodes(Collection& files) {
  files.change_json("node_circle",
                    [](json& j) {
                      j["nodes"][0]["children"] = {1};
                      j["nodes"][1]["children"] = {0};
                      j["scenes"][0]["nodes"] = {0};
                    },
                    {"nodes[1]"});
  files.change_json("node_two_parents",
                    [](json& j) {
                      j["nodes"].push_back({{"children", {0}}});
                      j["nodes"].push_back({{"children", {0}}});
                    },
                    {"nodes[0]"});
  files.change_json("node_child", [](json& j) { j["nodes"][0]["children"] = {5}; }, {"nodes[0].children[0]", "5", "2"});
  files.change_json("node_matrix", [](json& j) { j["nodes"][0]["matrix"] = {1, 2, 3}; }, {"nodes[0].matrix"});
  files.change_json("scene_missing", [](json& j) { j["scene"] = 3; }, {"scene", "3", "1"});
  files.change_json("material_missing", [](json& j) { primitive(j)["material"] = 2; }, {"meshes[0].primitives[0].material", "2"});
  files.change_json("material_color",
                    [](json& j) {
                      j["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1};
                    },
                    {"materials[0].pbrMetallicRoughness.baseColorFactor"});
}

/// The small plant with its leaf coded by Draco; edit(extension, primitive, coded bytes).
void add_draco_file(Collection& files, const std::string& name, const std::function<void(json&, json&, GltfBytes&)>& edit, Names names,
                    Status status = Status::bad_file) {
  files.change(
      name,
      [&](GltfBuilder& builder) {
        DracoMesh mesh;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        GltfBytes coded = encode_draco(mesh);
        json extension{{"attributes", {{"POSITION", 0}}}};
        edit(extension, primitive(builder.json), coded);
        json& added = add_draco(builder, primitive(builder.json), coded, extension["attributes"]);
        if (extension.contains("bufferView")) added["bufferView"] = extension["bufferView"];
      },
      std::move(names), status);
}

void add_draco_files(Collection& files) {
  const std::string place = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";
  add_draco_file(files, "draco_cut", [](json&, json&, GltfBytes& coded) { coded.resize(coded.size() / 2); }, {place});
  add_draco_file(files, "draco_none", [](json&, json&, GltfBytes& coded) { coded.assign(64, 'x'); }, {place});
  add_draco_file(
      files, "draco_points", [](json&, json&, GltfBytes& coded) { coded[7] = 0; }, {place}, Status::unsupported);
  add_draco_file(
      files, "draco_version", [](json&, json&, GltfBytes& coded) { coded[6] = 1; }, {"2.2", place}, Status::unsupported);
  add_draco_file(files, "draco_counts",
                 // "DRACO", version 2.2, a mesh, edgebreaker, no flags, standard traversal, 2^28 vertices, 2^29 triangles.
                 [](json&, json&, GltfBytes& coded) {
                   coded = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0, 0x80, 0x80, 0x80, 0x80, 1, 0x80, 0x80, 0x80, 0x80, 2, 0, 0, 0};
                 },
                 {place, "536870912", "268435456"});
  add_draco_file(files, "draco_attribute_id", [](json& extension, json&, GltfBytes&) { extension["attributes"]["POSITION"] = 7; },
                 {place + ".attributes.POSITION", "7"});
  add_draco_file(files, "draco_attributes_missing", [](json& extension, json&, GltfBytes&) { extension["attributes"] = json::object(); },
                 {place + ".attributes.POSITION"});
  add_draco_file(files, "draco_attribute_of_no_primitive",
                 [](json& extension, json&, GltfBytes&) { extension["attributes"]["NORMAL"] = 1; }, {place + ".attributes.NORMAL"});
  add_draco_file(files, "draco_view", [](json& extension, json&, GltfBytes&) { extension["bufferView"] = 40; },
                 {place + ".bufferView", "40", "4"});
  add_draco_file(files, "draco_fan", [](json&, json& leaf, GltfBytes&) { leaf["mode"] = 6; }, {"meshes[0].primitives[0].mode"});
}

/// The small plant with its leaf's positions coded by meshoptimizer; edit(extension, view, builder).
void add_meshopt_file(Collection& files, const std::string& name, const std::function<void(json&, json&, GltfBuilder&)>& edit, Names names,
                      Status status = Status::bad_file) {
  files.change(
      name,
      [&](GltfBuilder& builder) {
        json& extension = compress_view(builder, 0, {.stride = 12});
        edit(extension, builder.json["bufferViews"][0], builder);
      },
      std::move(names), status);
}

void add_meshopt_files(Collection& files) {
  const std::string place = "bufferViews[0].extensions.EXT_meshopt_compression";
  const auto set = [&](const std::string& name, const char* member, const json& value, Names names) {
    add_meshopt_file(
        files, name, [&](json& extension, json&, GltfBuilder&) { extension[member] = value; }, std::move(names));
  };
  set("meshopt_stride", "byteStride", 13, {place + ".byteStride", "13"});
  set("meshopt_count", "count", 5, {"bufferViews[0].byteLength", "48", "5", "12"});
  set("meshopt_count_billion", "count", 1000000000, {place + ".count", "1000000000"});
  set("meshopt_count_zero", "count", 0, {place + ".count", "0"});
  set("meshopt_mode", "mode", "VERTICES", {place + ".mode", "VERTICES"});
  set("meshopt_filter", "filter", "QUATERNION", {place + ".byteStride", "12"});
  set("meshopt_filter_unknown", "filter", 7, {place + ".filter"});
  set("meshopt_fallback", "buffer", 1, {place + ".buffer"});
  set("meshopt_past_buffer", "byteLength", 99999, {place, "99999"});
  add_meshopt_file(files, "meshopt_cut",
                   [](json& extension, json&, GltfBuilder&) { extension["byteLength"] = extension["byteLength"].get<int>() - 1; }, {place});
  add_meshopt_file(files, "meshopt_bytes",
                   [](json& extension, json&, GltfBuilder& builder) { builder.bin[extension["byteOffset"].get<std::size_t>()] = 0xe1; },
                   {place + ".mode"});
  add_meshopt_file(
      files, "meshopt_version",
      [](json& extension, json&, GltfBuilder& builder) { builder.bin[extension["byteOffset"].get<std::size_t>()] = 0xa1; }, {place, "1"},
      Status::unsupported);
  add_meshopt_file(files, "meshopt_not_compressed", [](json&, json& view, GltfBuilder&) { view.erase("extensions"); },
                   {"bufferViews[0].buffer"});
}

void add_placement(Collection& files) {
  const std::string place = "nodes[0].extensions.EXT_mesh_gpu_instancing";
  const auto instancing = [&](const std::string& name, const std::function<void(GltfBuilder&, json&)>& edit, Names names) {
    files.change(
        name,
        [&](GltfBuilder& builder) {
          json attributes = json::object();
          edit(builder, attributes);
          builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
        },
        std::move(names));
  };
  instancing("instancing_unequal",
             [](GltfBuilder& builder, json& attributes) {
               attributes["SCALE"] = builder.add_positions({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
               attributes["TRANSLATION"] = builder.add_positions({{1, 1, 1}, {2, 2, 2}});
             },
             {place + ".attributes", "TRANSLATION", "2", "SCALE", "3"});
  instancing("instancing_billion",
             [](GltfBuilder& builder, json& attributes) {
               builder.json["accessors"].push_back({{"componentType", kFloat}, {"type", "VEC3"}, {"count", 1000000000}});
               attributes["TRANSLATION"] = builder.json["accessors"].size() - 1;
             },
             {"accessors[3].count", "1000000000"});
  instancing("instancing_shape",
             [](GltfBuilder& builder, json& attributes) {
               attributes["ROTATION"] = builder.add_positions({{0, 0, 1}});
             },
             {"VEC4", place, "accessors[3]"});
  instancing("instancing_nan",
             [](GltfBuilder& builder, json& attributes) {
               attributes["TRANSLATION"] = builder.add_positions({{0, 0, 1}, {std::nanf(""), 0, 1}});
             },
             {place + " instance 1"});
  instancing("instancing_of_nothing", [](GltfBuilder&, json&) {}, {place + ".attributes"});

  const auto transform = [&](const std::string& name, const json& members, Names names) {
    files.change(
        name,
        [&](GltfBuilder& builder) {
          builder.set_texture(0, png(1, 1, {1, 2, 3, 255}));
          builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = members;
        },
        std::move(names));
  };
  const std::string texture = "materials[0].pbrMetallicRoughness.baseColorTexture.extensions";
  transform("texture_transform_offset", {{"offset", "left"}}, {texture + ".KHR_texture_transform.offset"});
  transform("texture_transform_scale", {{"scale", {1, 2, 3}}}, {texture + ".KHR_texture_transform.scale"});
  transform("texture_transform_rotation", {{"rotation", {0}}}, {texture + ".KHR_texture_transform.rotation"});
  transform("texture_transform_kind", 5, {texture + ".KHR_texture_transform"});
}

}  // namespace

std::vector<BadGltf> bad_gltf_files() {
  Collection files;
  add_containers(files);
  add_buffers(files);
  add_geometry(files);
  add_nodes(files);
  add_draco_files(files);
  add_meshopt_files(files);
  add_placement(files);
  return files.sorted();
}

std::vector<BadGltf> read_bad_gltf_list(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) throw std::runtime_error("cannot read " + path);
  std::vector<BadGltf> files;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream fields(line);
    BadGltf bad;
    std::string status;
    std::getline(fields, bad.file, '|');
    std::getline(fields, status, '|');
    bad.status = static_cast<Status>(std::stoi(status));
    for (std::string name; std::getline(fields, name, '|');) bad.names.push_back(name);
    files.push_back(bad);
  }
  return files;
}

}  // namespace coppice::test
