#include "import_gltf.h"

#include <algorithm>
#include <array>
#include <exception>
#include <map>
#include <new>
#include <regex>
#include <utility>

#include <tiny_gltf.h>

#include "components.h"
#include "coppice/format.h"
#include "gltf_document.h"
#include "gltf_materials.h"
#include "gltf_scene.h"
#include "gltf_triangles.h"

namespace coppice::bake {
namespace {

constexpr std::array<std::string_view, 16> kLeafNames{"leaf",  "leaves", "foliage", "foliole", "needle", "frond",  "feuille", "blatt",
                                                      "blätt", "laub",   "nadel",   "hoja",    "folha",  "foglia", "foglie",  "blad"};
// std::regex recurses once per character.
constexpr std::size_t kMaxMatchedChars = 256;
constexpr std::size_t kMaxWarnings = 32;
// Nodes times primitives: a bound on work that a small file can ask for.
constexpr std::size_t kMaxDraws = std::size_t{1} << 22;
// One leaf of this many triangles is more likely a crown that is welded together.
constexpr std::uint32_t kShellTriangles = 2000;

std::string ascii_lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool has_leaf_name(const std::string& name) {
  const std::string lower = ascii_lower(name);
  return std::any_of(kLeafNames.begin(), kLeafNames.end(), [&](std::string_view part) { return lower.find(part) != std::string::npos; });
}

/// A source material in use; numbers count the plant's materials in order of first use.
struct UsedMaterials {
  std::map<std::uint32_t, std::uint32_t> number_of;  ///< by the model's material index, kNone for the default material
  std::vector<std::uint32_t> sources;                ///< the reverse
};

std::uint32_t material_index(const tinygltf::Primitive& primitive) {
  return primitive.material < 0 ? kNone : static_cast<std::uint32_t>(primitive.material);
}

Result<UsedMaterials> used_materials(const tinygltf::Model& model, const std::vector<MeshInstance>& instances) {
  UsedMaterials used;
  std::size_t draw_count = 0;
  for (const MeshInstance& instance : instances) {
    const auto& primitives = model.meshes.at(instance.mesh).primitives;
    draw_count += primitives.size();
    if (draw_count > kMaxDraws) return Error{Status::unsupported, "more than 2^22 primitives in the scene"};
    for (const tinygltf::Primitive& primitive : primitives) {
      if (primitive.mode < TINYGLTF_MODE_TRIANGLES) continue;
      if (used.number_of.try_emplace(material_index(primitive), static_cast<std::uint32_t>(used.sources.size())).second)
        used.sources.push_back(material_index(primitive));
    }
  }
  if (used.sources.empty()) return Error{Status::bad_file, "no triangles in the scene"};
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

/// [materials.size()] whether each is foliage; at least one is.
Result<std::vector<bool>> find_leaf_materials(const std::vector<Material>& materials, const ImportOptions& options) {
  std::vector<bool> is_leaf(materials.size(), false);
  if (options.leaf_material) {
    try {
      const std::regex pattern(*options.leaf_material, std::regex::ECMAScript);
      for (std::size_t i = 0; i < materials.size(); ++i)
        is_leaf[i] = std::regex_search(materials[i].name.substr(0, kMaxMatchedChars), pattern);
    } catch (const std::regex_error&) {
      return Error{Status::invalid_argument, "--leaf-material is not a regular expression", Error::kNoOffset, *options.leaf_material};
    }
  } else {
    for (std::size_t i = 0; i < materials.size(); ++i) is_leaf[i] = has_leaf_name(materials[i].name);
  }
  if (std::find(is_leaf.begin(), is_leaf.end(), true) != is_leaf.end()) return is_leaf;
  return Error{Status::invalid_argument,
               options.leaf_material ? "no leaves: --leaf-material matches none of the materials"
                                     : "no leaves: no material has a leaf's name; choose with --leaf-material REGEX",
               Error::kNoOffset, "the materials are " + name_list(materials)};
}

struct FoliageAndWood {
  TriangleSoup foliage, wood;
};

Result<FoliageAndWood> gather_triangles(const tinygltf::Model& model, const std::vector<MeshInstance>& instances, const UsedMaterials& used,
                                        const std::vector<bool>& is_leaf, std::vector<std::string>& warnings) {
  FoliageAndWood soups;
  for (std::uint32_t i = 0; i < instances.size(); ++i) {
    const auto& primitives = model.meshes.at(instances[i].mesh).primitives;
    for (std::uint32_t p = 0; p < primitives.size(); ++p) {
      if (primitives[p].mode < TINYGLTF_MODE_TRIANGLES) continue;
      const std::uint32_t material = used.number_of.at(material_index(primitives[p]));
      TriangleSoup& soup = is_leaf[material] ? soups.foliage : soups.wood;
      COPPICE_CHECK(append_primitive(model, instances[i], i, p, material, soup, warnings));
    }
  }
  if (soups.wood.mesh.triangle_materials.size() > COPPICE_MAX_WOOD_TRIANGLES)
    return Error{Status::unsupported, "more than 2^24 triangles of wood"};
  return soups;
}

void warn_of_leaves(Plant& plant, std::uint32_t dropped_count) {
  if (dropped_count > 0) plant.warnings.push_back(std::to_string(dropped_count) + " leaves without area dropped");
  const auto largest = std::max_element(plant.leaves.begin(), plant.leaves.end(),
                                        [](const LeafRange& a, const LeafRange& b) { return a.triangle_count < b.triangle_count; });
  if (largest->triangle_count >= kShellTriangles)
    plant.warnings.push_back("a leaf has " + std::to_string(largest->triangle_count) +
                             " triangles: leaves that share vertices cannot be told apart");
}

/// A file's own names may hold control characters, which would split the line or reach the terminal.
void replace_control_characters(std::string& line) {
  for (char& c : line)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = '?';
}

void limit_warnings(std::vector<std::string>& warnings) {
  for (std::string& warning : warnings) replace_control_characters(warning);
  if (warnings.size() <= kMaxWarnings) return;
  const std::size_t more = warnings.size() - kMaxWarnings;
  warnings.resize(kMaxWarnings);
  warnings.push_back("and " + std::to_string(more) + " more warnings");
}

Result<Plant> import_model(const tinygltf::Model& model, const ImportOptions& options) {
  Plant plant;
  COPPICE_TRY(instances, mesh_instances(model));
  COPPICE_TRY(used, used_materials(model, instances));
  for (const std::uint32_t source : used.sources) plant.materials.push_back(convert_material(model, source, plant.warnings));
  COPPICE_TRY(is_leaf, find_leaf_materials(plant.materials, options));
  COPPICE_TRY(soups, gather_triangles(model, instances, used, is_leaf, plant.warnings));

  plant.wood = compact(soups.wood.mesh);
  soups.wood = {};
  SplitFoliage foliage = split_leaves(std::move(soups.foliage));
  if (foliage.leaves.empty())
    return Error{Status::bad_file, "no leaves: the foliage has no area", Error::kNoOffset,
                 std::to_string(foliage.dropped_leaf_count) + " degenerate leaves"};
  plant.foliage = std::move(foliage.mesh);
  plant.leaves = std::move(foliage.leaves);
  warn_of_leaves(plant, foliage.dropped_leaf_count);
  plant.images = take_images(model, plant.materials, plant.warnings);
  limit_warnings(plant.warnings);
  return plant;
}

/// One line that starts with the file's name.
Error named(Error error, const std::filesystem::path& path) {
  const std::string name = path.string();
  if (!error.detail.starts_with(name)) error.detail = error.detail.empty() ? name : name + ": " + error.detail;
  replace_control_characters(error.detail);
  return error;
}

/// Runs an import to its end, whatever tinygltf, the standard library or memory do on the way.
template <class Load>
Result<Plant> import_guarded(const std::filesystem::path& path, const ImportOptions& options, const Load& load) {
  try {
    const auto import = [&]() -> Result<Plant> {
      COPPICE_TRY(model, load());
      COPPICE_TRY(plant, import_model(*model, options));
      plant.name = path.stem().string();
      return plant;
    };
    Result<Plant> plant = import();
    if (!plant) return named(plant.error(), path);
    return plant;
  } catch (const std::bad_alloc&) {
    return named(Error{Status::out_of_memory, "out of memory"}, path);
  } catch (const std::exception& error) {
    return named(Error{Status::internal, "import failed", Error::kNoOffset, error.what()}, path);
  }
}

}  // namespace

std::span<const std::string_view> leaf_names() {
  return kLeafNames;
}

Result<Plant> import_gltf(const std::filesystem::path& path, const ImportOptions& options) {
  return import_guarded(path, options, [&] { return load_gltf(path); });
}

Result<Plant> import_gltf_bytes(std::span<const std::uint8_t> file, const std::filesystem::path& path, const ImportOptions& options) {
  return import_guarded(path, options, [&] { return load_gltf_bytes(file, path.parent_path()); });
}

}  // namespace coppice::bake
