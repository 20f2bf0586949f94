#include "import_gltf.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <map>
#include <new>
#include <set>
#include <utility>

#include <tiny_gltf.h>

#include "bounds.h"
#include "coppice/format.h"
#include "failure_text.h"
#include "find_leaves.h"
#include "gltf_document.h"
#include "gltf_instances.h"
#include "gltf_lines.h"
#include "gltf_materials.h"
#include "gltf_pose.h"
#include "gltf_triangles.h"
#include "printable.h"
#include "texture_regions.h"
#include "triangle_soup.h"
#include "vertex_colors.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kMaxWarnings = 32;
// A leaf of this many triangles is more likely a crown that is welded together.
constexpr std::uint32_t kShellTriangles = 2000;

/// The source materials in use. Numbers count the plant's materials in order of first use.
struct UsedMaterials {
  std::map<std::uint32_t, std::uint32_t> number_of;  ///< by the model's material index, kNone for the default material
  std::vector<std::uint32_t> sources;                ///< [number] the model's material index
};

std::uint32_t material_index(const tinygltf::Primitive& primitive) {
  return primitive.material < 0 ? kNone : static_cast<std::uint32_t>(primitive.material);
}

Result<UsedMaterials> used_materials(const tinygltf::Model& model, const std::vector<MeshInstance>& instances) {
  UsedMaterials used;
  for (const MeshInstance& instance : instances)
    for (const tinygltf::Primitive& primitive : model.meshes.at(instance.mesh).primitives) {
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES) continue;
      if (used.number_of.try_emplace(material_index(primitive), static_cast<std::uint32_t>(used.sources.size())).second)
        used.sources.push_back(material_index(primitive));
    }
  if (used.sources.empty()) {
    const std::size_t others = model.scenes.size() - std::min<std::size_t>(model.scenes.size(), 1);
    return Error{Status::bad_file, "no triangles and no lines in the scene", Error::kNoOffset,
                 others > 0 ? "of its " + std::to_string(others + 1) + " scenes only the default one, or the first, is read" : ""};
  }
  if (used.sources.size() > COPPICE_MAX_MATERIALS) return Error{Status::unsupported, "more than 256 materials in use"};
  return used;
}

std::string name_list(const std::vector<Material>& materials) {
  constexpr std::size_t kMaxNames = 20;
  std::string list;
  for (std::size_t i = 0; i < std::min(materials.size(), kMaxNames); ++i)
    list += (i == 0 ? "'" : ", '") + materials[i].name.substr(0, 64) + "'";
  return materials.size() > kMaxNames ? list + ", ..." : list;
}

/// All rules of the options about materials, in the order in which they count.
std::vector<ClassRule> all_rules(const ImportOptions& options) {
  std::vector<ClassRule> rules;
  if (options.leaf_material) rules.push_back({.material = *options.leaf_material, .part = PlantPart::leaf, .source = "--leaf-material"});
  if (options.wood_material) rules.push_back({.material = *options.wood_material, .part = PlantPart::wood, .source = "--wood-material"});
  rules.insert(rules.end(), options.classes.begin(), options.classes.end());
  return rules;
}

Result<std::vector<std::vector<MaterialRule>>> material_rules(const std::vector<Material>& materials, const ImportOptions& options,
                                                              std::vector<std::string>& warnings) {
  COPPICE_TRY(rules, apply_class_rules(all_rules(options), materials, warnings));
  if (!options.leaf_material) return rules;
  bool matches = false;
  for (auto& of_material : rules) {
    matches = matches || (!of_material.empty() && of_material.front().source == "--leaf-material");
    of_material.push_back({.part = PlantPart::wood, .source = "not in --leaf-material"});
  }
  if (matches) return rules;
  return Error{Status::invalid_argument, "no leaves: --leaf-material matches none of the materials", Error::kNoOffset,
               "the materials are " + name_list(materials)};
}

Result<TriangleSoup> gather_triangles(const tinygltf::Model& model, const std::vector<MeshInstance>& instances, const UsedMaterials& used,
                                      std::optional<std::uint32_t> wind_color_set, std::vector<std::string>& warnings) {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < instances.size(); ++i) {
    const auto& primitives = model.meshes.at(instances[i].mesh).primitives;
    for (std::uint32_t p = 0; p < primitives.size(); ++p) {
      if (primitives[p].mode < TINYGLTF_MODE_TRIANGLES) continue;
      const std::uint32_t material = used.number_of.at(material_index(primitives[p]));
      COPPICE_CHECK(append_primitive(model, {instances[i], i, p, material, wind_color_set}, soup, warnings));
    }
  }
  if (wind_color_set && soup.mesh.wind_weights.empty())
    warnings.push_back("--wind-weights: no mesh has COLOR_" + std::to_string(*wind_color_set) + "; the wood decides what bends");
  return soup;
}

/// Warns once for each material that has welded crowns or the like.
void warn_of_shells(Plant& plant) {
  for (std::size_t first = 0, last = 0; first < plant.classes.size(); first = last) {
    std::uint32_t count = 0, largest = 0;
    const std::uint32_t material = plant.classes[first].material;
    for (; last < plant.classes.size() && plant.classes[last].material == material; ++last) {
      if (!plant.classes[last].is_shell) continue;
      count += plant.classes[last].piece_count;
      largest = std::max(largest, plant.classes[last].triangle_count);
    }
    if (count == 0) continue;
    plant.warnings.push_back("material '" + plant.materials[material].name.substr(0, 64) + "': " + std::to_string(count) +
                             " welded pieces of up to " + std::to_string(largest) +
                             " triangles cannot be split into leaves and are wood; --leaf-material makes each of them a leaf");
  }
}

/// Warns once for each material whose form contradicts its name.
void warn_of_names(Plant& plant) {
  std::map<std::uint32_t, std::uint64_t> counts;
  for (const PieceClass& each : plant.classes)
    if (each.against_name && each.part == PlantPart::leaf) counts[each.material] += each.piece_count;
  for (const auto& [material, count] : counts)
    plant.warnings.push_back("material '" + plant.materials[material].name.substr(0, 64) + "': by their form " + std::to_string(count) +
                             " pieces are leaves, though its name speaks for wood; --wood-material makes wood of them");
}

void warn_of_leaves(Plant& plant, std::uint32_t dropped_count, bool has_crown) {
  if (dropped_count > 0) plant.warnings.push_back(std::to_string(dropped_count) + " leaves without area dropped");
  if (plant.leaves.empty()) {
    const bool was_guessed = std::ranges::any_of(plant.classes, [](const PieceClass& each) { return each.evidence.sum() != 0.0; });
    plant.warnings.emplace_back(std::string("no leaves: all of the plant is wood") +
                                (was_guessed ? "; --leaf-material REGEX makes leaves of a material's pieces" : ""));
    return;
  }
  if (!has_crown)
    plant.warnings.push_back("only " + std::to_string(plant.leaves.size()) +
                             " small leaves: all else is wood; --leaf-material REGEX makes leaves of a material's pieces");
  warn_of_names(plant);
  warn_of_shells(plant);
  const auto largest = std::ranges::max_element(plant.leaves, {}, &LeafRange::triangle_count);
  if (largest->triangle_count >= kShellTriangles)
    plant.warnings.push_back("a leaf has " + std::to_string(largest->triangle_count) +
                             " triangles: leaves that share vertices cannot be separated");
}

/// Splits the soup into the plant's leaves and wood.
Result<void> take_parts(TriangleSoup soup, const ImportOptions& options, Plant& plant) {
  COPPICE_TRY(rules, material_rules(plant.materials, options, plant.warnings));
  FoundParts found = find_leaves(std::move(soup), plant.materials, plant.images, rules);
  if (found.wood.triangle_materials.size() > COPPICE_MAX_WOOD_TRIANGLES)
    return Error{Status::unsupported, "more than 2^24 triangles of wood"};
  const auto is_kept = [](const PieceClass& each) { return each.part != PlantPart::dropped; };
  if (std::ranges::none_of(found.classes, is_kept))
    return Error{Status::bad_file, "no leaves and no wood: all is dropped or without area", Error::kNoOffset,
                 "the materials are " + name_list(plant.materials)};
  plant.foliage = std::move(found.foliage);
  plant.leaves = std::move(found.leaves);
  plant.wood = std::move(found.wood);
  plant.classes = std::move(found.classes);
  warn_of_leaves(plant, found.dropped_leaf_count, found.has_crown);
  return {};
}

void limit_warnings(std::vector<std::string>& warnings) {
  for (std::string& warning : warnings) warning = printable(warning);  // a warning may quote the file's own names
  if (warnings.size() <= kMaxWarnings) return;
  const std::size_t more = warnings.size() - kMaxWarnings;
  warnings.resize(kMaxWarnings);
  warnings.push_back("and " + std::to_string(more) + " more warnings");
}

void add_warning(std::string line, std::vector<std::string>& warnings) {
  if (!line.empty()) warnings.push_back(std::move(line));
}

// Lines about what a document holds that no plant has; empty if there is none of it.

/// Appends "2 cameras" to a list; nothing for 0.
void add_count(std::size_t count, const std::string& what, std::string& list) {
  if (count > 0) list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

/// Other scenes, cameras and lights.
std::string scenery_text(const tinygltf::Model& model) {
  std::string list;
  add_count(model.scenes.size() - std::min<std::size_t>(model.scenes.size(), 1), "other scene", list);
  const auto count_nodes = [&model](const auto& is_one) { return static_cast<std::size_t>(std::ranges::count_if(model.nodes, is_one)); };
  add_count(count_nodes([](const tinygltf::Node& node) { return node.camera >= 0; }), "camera", list);
  add_count(count_nodes([](const tinygltf::Node& node) { return node.extensions.count("KHR_lights_punctual") > 0; }), "light", list);
  return list.empty() ? list : "left out: " + list;
}

/// Points that the instances show.
std::string points_text(const tinygltf::Model& model, const std::vector<MeshInstance>& instances) {
  std::size_t count = 0;
  for (const MeshInstance& instance : instances)
    for (const tinygltf::Primitive& primitive : model.meshes.at(instance.mesh).primitives)
      count += primitive.mode < TINYGLTF_MODE_TRIANGLES ? 1u : 0u;
  std::string list;
  add_count(count, "primitive", list);
  return list.empty() ? list : "left out: " + list + " of points, or of lines without length";
}

/// Materials whose images some meshes cannot show: they ask for a set of texture coordinates, not the first, that the mesh lacks.
std::string uvs_text(const tinygltf::Model& model, const std::vector<MeshInstance>& instances) {
  std::set<std::string> names;
  for (const MeshInstance& instance : instances)
    for (const tinygltf::Primitive& primitive : model.meshes.at(instance.mesh).primitives) {
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES || primitive.material < 0) continue;
      const tinygltf::Material& material = model.materials.at(static_cast<std::size_t>(primitive.material));
      const std::uint32_t set = texture_uvs(model, material_index(primitive)).set;
      const std::string name = "TEXCOORD_" + std::to_string(set);
      if (set > 0 && material.pbrMetallicRoughness.baseColorTexture.index >= 0 && !primitive.attributes.contains(name))
        names.insert("'" + material.name.substr(0, 64) + "' (" + name + ")");
    }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? list : "meshes without the texture coordinates of their materials show one texel: " + list;
}

/// Light that materials emit. materials  indices, kNone for glTF's default material
std::string emission_text(const tinygltf::Model& model, const std::vector<std::uint32_t>& materials) {
  constexpr std::size_t kMaxNames = 8;
  std::size_t count = 0;
  std::string names;
  for (const std::uint32_t index : materials) {
    if (index == kNone) continue;
    const tinygltf::Material& material = model.materials.at(index);
    if (!std::ranges::any_of(material.emissiveFactor, [](double factor) { return factor > 0.0; })) continue;
    if (count++ < kMaxNames) names += (names.empty() ? "'" : ", '") + material.name.substr(0, 64) + "'";
  }
  if (count > kMaxNames) names += ", ...";
  return count == 0 ? names : "the light that materials emit is left out: " + names;
}

Result<Plant> import_model(tinygltf::Model& model, const std::filesystem::path& folder, const ImportOptions& options) {
  Plant plant;
  COPPICE_TRY(transform, scene_from_file(options));
  COPPICE_TRY(lines, widen_lines(model));
  COPPICE_TRY(all_instances, mesh_instances(model, transform));
  COPPICE_TRY(chosen, choose_plant(model, std::move(all_instances), options.plant));
  const std::vector<MeshInstance>& instances = chosen.instances;
  add_warning(level_line(chosen.contents), plant.warnings);
  add_warning(contents_line(chosen.contents), plant.warnings);
  add_warning(pose_line(model), plant.warnings);
  add_warning(lines_text(lines, instances), plant.warnings);
  add_warning(points_text(model, instances), plant.warnings);
  COPPICE_TRY(used, used_materials(model, instances));
  add_warning(uvs_text(model, instances), plant.warnings);
  add_warning(emission_text(model, used.sources), plant.warnings);
  for (const std::uint32_t source : used.sources) plant.materials.push_back(convert_material(model, source, plant.warnings));
  COPPICE_TRY(soup, gather_triangles(model, instances, used, options.wind_color_set, plant.warnings));
  apply_vertex_colors(soup, plant.materials, plant.warnings);
  // The images' colours and holes are evidence for leaves.
  const ImageFolder image_folder{folder, options.outside_files, CostLimit{options.max_source_triangles}.triangles(), options.on_read};
  COPPICE_CHECK(move_into(plant.images, take_images(model, used.sources, plant.materials, image_folder, plant.warnings)));
  const glm::dvec3 anchor = soup.anchor;
  COPPICE_CHECK(take_parts(std::move(soup), options, plant));
  bring_uvs_near_zero(plant.foliage, plant.leaves);
  bring_uvs_near_zero(plant.wood, {});
  add_warning(place_origin(plant, anchor, options.origin), plant.warnings);
  add_warning(size_warning(plant_size_m(plant), options.metres_per_unit), plant.warnings);
  limit_warnings(plant.warnings);
  return plant;
}

/// One line that starts with the file's name.
Error named(Error error, const std::filesystem::path& path) {
  const std::string name = path.string();
  if (!error.detail.starts_with(name)) error.detail = error.detail.empty() ? name : name + ": " + error.detail;
  error.detail = printable(error.detail);
  return error;
}

/// Runs `read` and turns exceptions of tinygltf, the standard library or memory into errors.
template <class Value, class Read>
Result<Value> guarded(const std::filesystem::path& path, const Read& read) {
  try {
    Result<Value> value = read();
    if (!value) return named(value.error(), path);
    return value;
  } catch (const std::bad_alloc&) {
    return named(Error{Status::out_of_memory, "out of memory"}, path);
  } catch (const std::exception& error) {
    return named(Error{Status::internal, "import failed", Error::kNoOffset, failure_text(error)}, path);
  }
}

template <class Load>
Result<Plant> import_guarded(const std::filesystem::path& path, const ImportOptions& options, const Load& load) {
  return guarded<Plant>(path, [&]() -> Result<Plant> {
    COPPICE_TRY(model, load());
    COPPICE_TRY(plant, import_model(*model, path.parent_path(), options));
    plant.name = path.stem().string();
    return plant;
  });
}

}  // namespace

/// (x, y, z) of a file with +Z up is (x, z, -y) of one with +Y up.
Result<glm::dmat4> scene_from_file(const ImportOptions& options) {
  const double unit_m = options.metres_per_unit;
  if (!std::isfinite(unit_m) || unit_m <= 0.0)
    return Error{Status::invalid_argument, "--unit is not a length", Error::kNoOffset, std::to_string(unit_m)};
  glm::dmat4 transform(0.0);
  transform[0][0] = unit_m;
  const bool z_up = options.up == UpAxis::z;
  transform[1][z_up ? 2 : 1] = z_up ? -unit_m : unit_m;
  transform[2][z_up ? 1 : 2] = unit_m;
  transform[3][3] = 1.0;
  return transform;
}

Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options) {
  return import_guarded(path, options,
                        [&] { return load_gltf(path, options.outside_files, {options.max_source_triangles}, options.on_read); });
}

Result<SourceContents> read_contents(const std::filesystem::path& path, const ImportOptions& options) {
  return guarded<SourceContents>(path, [&]() -> Result<SourceContents> {
    COPPICE_TRY(model, load_gltf(path, options.outside_files, {options.max_source_triangles}));
    COPPICE_TRY(transform, scene_from_file(options));
    COPPICE_CHECK(widen_lines(*model));
    COPPICE_TRY(instances, mesh_instances(*model, transform));
    COPPICE_TRY(chosen, choose_plant(*model, std::move(instances), options.plant));
    chosen.contents.scenery = scenery_text(*model);
    return std::move(chosen.contents);
  });
}

Result<Plant> import_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& path, const ImportOptions& options) {
  return import_guarded(path, options,
                        [&] { return load_gltf_bytes(file, path.parent_path(), options.outside_files, {options.max_source_triangles}); });
}

}  // namespace coppice::bake
