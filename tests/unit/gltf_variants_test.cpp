// Which nodes of a file are the plant: generated packs, of which one plant is to be taken, and plants of many nodes, which are to stay
// whole.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "gltf_variants.h"
#include "imported.h"
#include "node_names.h"
#include "pack_gltf.h"
#include "process.h"
#include "results.h"
#include "seeded_random.h"

namespace coppice::test::gltf_variants_test {

using bake::ImportOptions;
using bake::Plant;
using bake::SourceContents;

struct Contents {
  std::size_t variants = 1;
  std::size_t leaves = 0;  ///< leaves of the plant that is taken
  std::size_t left = 0;    ///< levels, billboards and the like
};

/// One file, and what is to come of it.
struct Case {
  std::string name;
  Contents expected;
  std::function<void(Pack&)> fill;
};
void PrintTo(const Case& each, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << each.name;
}

void add_three_levels(Pack& p, const std::string& stem, float height, std::uint64_t seed, glm::vec3 at = {}, int parent = -1) {
  p.part(stem + "_LOD0", tree(300, height, seed), at, parent);
  p.part(stem + "_LOD1", tree(90, height, seed + 1), at, parent);
  p.part(stem + "_LOD2", tree(30, height, seed + 2), at, parent);
}

std::vector<Case> packs() {
  std::vector<Case> cases;
  const auto add = [&](const char* name, const Contents& expected, const std::function<void(Pack&)>& fill) {
    cases.push_back({name, expected, fill});
  };
  add("levels_billboard_collision", {1, 300, 4}, [](Pack& p) {
    add_three_levels(p, "oak", 5, 1);
    p.part("oak_billboard", {{"card", crossed_quads(5, 3)}});
    p.part("UCX_oak_01", {{"grey", post(5, 1)}});
  });
  add("levels_of_parts", {1, 300, 3}, [](Pack& p) {
    p.part("Trunk_LOD0", trunk_part(5));
    p.part("Leaves_LOD0", crown_part(300, 5, 1));
    p.part("Trunk_LOD1", trunk_part(5));
    p.part("Leaves_LOD1", crown_part(80, 5, 2));
    p.part("Tree_LOD2", tree(20, 5, 3));
  });
  add("levels_as_groups", {1, 300, 2}, [](Pack& p) {
    const int oak = p.node("Oak", -1);
    for (int level = 0; level < 3; ++level) {
      const int group = p.node("LOD" + std::to_string(level), -1, {}, oak);
      p.part("trunk", trunk_part(5), {}, group);
      p.part("leaves", crown_part(300 >> (2 * level), 5, 1), {}, group);
    }
  });
  add("parts_without_names", {1, 340, 0}, [](Pack& p) {
    p.part("", crown_part(300, 5, 1));
    auto flowers = crown_part(40, 5, 2);
    for (auto& part : flowers) part.first = "flowers";
    p.part("", flowers);
  });
  add("level_0_has_no_number", {1, 300, 2}, [](Pack& p) {
    p.part("Oak", tree(300, 5, 1));
    p.part("Oak_LOD1", tree(90, 5, 2));
    p.part("Oak_lod_2", tree(30, 5, 3));
  });
  add("levels_in_a_row", {1, 300, 3}, [](Pack& p) {
    for (int i = 0; i < 4; ++i) p.part("PineLOD" + std::to_string(i), tree(300 >> i, 5, 4), {static_cast<float>(5 * i), 0, 0});
  });
  add("weak_levels", {1, 300, 2}, [](Pack& p) {
    p.part("oak_L0", tree(300, 5, 1));
    p.part("oak_L1", tree(90, 5, 1));
    p.part("oak_L2", {trunk_part(5)[0], {"leaf", leaves(8, {0, 3.2f, 0}, {1.4f, 1.6f, 1.4f}, 0.5f, 1)}});
  });
  add("levels_by_words", {1, 300, 2}, [](Pack& p) {
    p.part("oak_High", tree(300, 5, 1));
    p.part("oak_Mid", tree(120, 5, 1));
    p.part("oak_Low_Poly", tree(40, 5, 1));
  });
  add("levels_by_words_as_groups", {1, 300, 2}, [](Pack& p) {
    const std::vector<std::string> names{"High", "Medium", "Low"};
    for (std::size_t level = 0; level < 3; ++level) {
      const int group = p.node(names[level], -1);
      p.part("trunk", trunk_part(5), {}, group);
      p.part("leaves", crown_part(300 >> (2 * level), 5, 1), {}, group);
    }
  });
  add("level_0_beside_a_word", {1, 300, 1}, [](Pack& p) {
    p.part("Beech", tree(300, 5, 1));
    p.part("Beech_LowPoly", tree(40, 5, 1));
  });
  add("weak_levels_as_groups", {1, 300, 2}, [](Pack& p) {
    for (int level = 0; level < 3; ++level) {
      const int group = p.node("oak_L" + std::to_string(level), -1);
      p.part("trunk", {{"bark", post(4, 0.3f, {}, {}, 64 >> (2 * level))}}, {}, group);
      p.part("leaves", crown_part(300 >> (2 * level), 5, 1), {}, group);
    }
  });
  add("levels_with_dots_brackets_and_words", {1, 300, 4}, [](Pack& p) {
    p.part("oak.lod.0", tree(300, 5, 1));
    p.part("oak.lod.1", tree(90, 5, 2));
    p.part("Oak (LOD 2)", tree(30, 5, 3));
    p.part("oak_LOD_low", tree(20, 5, 3));
    p.part("oak lod03.001", tree(10, 5, 3));
  });
  add("hidden_nodes", {1, 300, 1}, [](Pack& p) {
    p.part("oak", tree(300, 5, 1));
    const int off = p.node("old", -1);
    p.part("elm", tree(250, 6, 2), {}, off);
    p.part("ash", tree(200, 6, 3), {}, off);
    p.file.node(off)["extensions"]["KHR_node_visibility"]["visible"] = false;
    p.file.json["extensionsUsed"] = {"KHR_node_visibility"};
    p.file.json["extensionsRequired"] = {"KHR_node_visibility"};
  });
  add("hidden_by_scale", {1, 300, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    p.part("leaves", crown_part(300, 5, 1));
    p.file.node(p.part("elm", tree(250, 6, 2), {20, 0, 0}))["scale"] = {0, 0, 0};
  });
  add("levels_of_unknown_names_the_coarsest_first", {3, 300, 0}, [](Pack& p) {
    p.part("Oak_500tris", tree(30, 5, 1));
    p.part("Oak_2000tris", tree(90, 5, 1));
    p.part("Oak_9000tris", tree(300, 5, 1));
  });
  add("seasons", {3, 200, 0}, [](Pack& p) {
    p.part("Tree_Summer", tree(200, 5, 1));
    p.part("Tree_Autumn", tree(150, 5, 2));
    p.part("Tree_Winter", tree(20, 5, 3));
  });
  add("levels_in_mesh_names_below_wrappers", {1, 300, 2}, [](Pack& p) {
    int parent = -1;
    for (const char* name : {"Sketchfab_model", "root", "GLTF_SceneRootNode", "RootNode"}) parent = p.node(name, -1, {}, parent);
    for (int level = 0; level < 3; ++level) {
      const int object = p.node("Object_" + std::to_string(4 + level), -1, {}, parent);
      p.node("Object_" + std::to_string(10 + level), p.mesh(tree(300 >> (2 * level), 5, 1), "Beech_LOD" + std::to_string(level)), {},
             object);
    }
  });
  add("msft_lod", {1, 300, 1}, [](Pack& p) {
    const int fine = p.part("Tree A", tree(300, 5, 1));
    const int coarse = p.part("Tree far", tree(60, 5, 2));
    p.file.node(fine)["extensions"]["MSFT_lod"]["ids"] = {coarse};
    p.file.json["extensionsUsed"] = {"MSFT_lod"};
    p.file.json["extensionsRequired"] = {"MSFT_lod"};
  });
  add("three_variants_with_levels_at_the_origin", {3, 300, 9}, [](Pack& p) {
    for (const char* name : {"oak_A", "oak_B", "oak_C"}) {
      add_three_levels(p, name, 5.0f + static_cast<float>(name[4] - 'A'), static_cast<std::uint64_t>(name[4]));
      p.part(std::string(name) + "_billboard", {{"card", crossed_quads(5, 3)}});
    }
  });
  add("row_of_unnamed_trees", {4, 300, 0}, [](Pack& p) {
    for (int i = 0; i < 4; ++i)
      p.part("Object_" + std::to_string(i), tree(300 - 20 * i, 5, static_cast<std::uint64_t>(i)), {4.0f * static_cast<float>(i), 0, 0});
  });
  add("row_below_wrappers_in_two_nodes_each", {3, 280, 0}, [](Pack& p) {
    const int root = p.node("RootNode", -1, {}, p.node("Sketchfab_model", -1));
    for (int i = 0; i < 3; ++i) {
      const std::string name = "Birch_" + std::to_string(i + 1);
      const int object = p.node(name, -1, {0, 0, 6.0f * static_cast<float>(i)}, root);
      p.part(name + "_Bark_0", trunk_part(6 + static_cast<float>(i)), {}, object);
      p.part(name + "_Leaves_0", crown_part(280 - 10 * i, 6 + static_cast<float>(i), 7), {}, object);
    }
  });
  add("parts_of_three_variants_at_the_origin", {3, 251, 0}, [](Pack& p) {
    for (int i = 1; i <= 3; ++i) p.part("oak" + std::to_string(i) + "_trunk", trunk_part(5, static_cast<std::uint64_t>(i)));
    for (int i = 1; i <= 3; ++i) p.part("oak" + std::to_string(i) + "_leaves", crown_part(250 + i, 5, static_cast<std::uint64_t>(i)));
  });
  add("copies_by_blender_in_a_row", {3, 240, 0}, [](Pack& p) {
    const std::vector<std::string> suffixes{"", ".001", ".002"};
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::vec3 at(8.0f * static_cast<float>(i), 0, 0);
      p.part("trunk" + suffixes[i], trunk_part(5, i), at);
      p.part("leaves" + suffixes[i], crown_part(240 + static_cast<int>(i), 5, i), at);
    }
  });
  add("row_on_ground", {3, 200, 1}, [](Pack& p) {
    p.part("Ground", {{"soil", plate(30)}});
    for (int i = 0; i < 3; ++i)
      p.part("Tree_" + std::to_string(i), tree(200 + i, 5, static_cast<std::uint64_t>(i)), {6.0f * static_cast<float>(i) - 6.0f, 0, 0});
  });
  add("three_sizes_of_one_material_at_the_origin", {3, 100, 0}, [](Pack& p) {
    p.part("bush_small", crown_part(100, 1, 1));
    p.part("bush_medium", crown_part(150, 2, 2), {0, -0.3f, 0});
    p.part("bush_large", crown_part(200, 3, 3), {0, -0.6f, 0});
  });
  add("three_species_of_one_material_in_a_row", {3, 200, 0}, [](Pack& p) {
    const std::vector<std::string> names{"birch", "oak", "pine"};
    for (std::size_t i = 0; i < names.size(); ++i)
      p.part(names[i], {{"leaves_atlas", crown_part(200 + static_cast<int>(i), 5, i)[0].second}}, {5.0f * static_cast<float>(i), 0, 0});
  });
  add("variants_in_a_grid_by_name", {6, 150, 0}, [](Pack& p) {
    for (int i = 0; i < 6; ++i)
      p.part("SM_Shrub_Var" + std::to_string(i + 1), crown_part(150 + i, 2, static_cast<std::uint64_t>(i)),
             {3.0f * static_cast<float>(i % 3), 0, 3.0f * static_cast<float>(i / 3)});
  });
  add("billboard_by_shape", {1, 300, 1}, [](Pack& p) {
    p.part("Cylinder", trunk_part(5));
    p.part("Icosphere.002", crown_part(300, 5, 1));
    p.part("Plane.003", {{"card", crossed_quads(4.9f, 2.7f)}});
  });
  add("impostor_beside", {1, 300, 1}, [](Pack& p) {
    p.part("elm", tree(300, 5, 1));
    p.part("Elm Impostor", {{"card", crossed_quads(5, 3, 4)}}, {8, 0, 0});
  });
  add("colliders", {1, 300, 3}, [](Pack& p) {
    p.part("oak", tree(300, 5, 1));
    p.part("oak_col", {{"grey", post(5, 0.3f)}});
    p.part("TrunkCollider", {{"grey", post(4, 0.3f)}});
    p.part("trunk-convcolonly", {{"grey", post(4, 0.3f)}});
  });
  return cases;
}

std::vector<Case> whole_plants() {
  std::vector<Case> cases;
  const auto add = [&](const char* name, const Contents& expected, const std::function<void(Pack&)>& fill) {
    cases.push_back({name, expected, fill});
  };
  add("trunk_branches_leaves", {1, 300, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    p.part("branches", {{"bark", post(2, 0.1f, {0, 2, 0}, {1, 0, 0})}});
    p.part("leaves", crown_part(300, 5, 1));
  });
  add("two_stems", {1, 310, 0}, [](Pack& p) {
    p.part("stem_1", tree(150, 5, 1), {-0.3f, 0, 0});
    p.part("stem_2", tree(160, 5, 2), {0.3f, 0, 0.1f});
  });
  add("stems_named_like_trees", {1, 480, 0}, [](Pack& p) {
    p.part("birch_1", tree(150, 6, 1), {-0.4f, 0, 0});
    p.part("birch_2", tree(160, 6, 2), {0.4f, 0, 0.1f});
    p.part("birch_3", tree(170, 6, 3), {0, 0, 0.5f});
  });
  add("leaf_nodes", {1, 400, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    const int leaf = p.mesh({{"leaf", leaves(1, {}, {}, 0.2f, 1)}});
    bake::SeededRandom random(3);
    for (int i = 0; i < 400; ++i)
      p.node("leaf." + std::to_string(i), leaf,
             {static_cast<float>(2 * random.uniform() - 1), static_cast<float>(2 + 3 * random.uniform()),
              static_cast<float>(2 * random.uniform() - 1)});
  });
  add("gpu_instances", {1, 300, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    const int node = p.node("leaves", p.mesh({{"leaf", leaves(1, {}, {}, 0.2f, 1)}}));
    std::vector<glm::vec3> places;
    for (int i = 0; i < 300; ++i) places.emplace_back(std::sin(i), 2.0f + 0.01f * static_cast<float>(i), std::cos(i));
    p.file.node(node)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] = p.file.add_positions(places);
    p.file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  });
  add("numbered_leaf_groups", {1, 320, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    for (int i = 1; i <= 4; ++i) p.part("leaves_0" + std::to_string(i), crown_part(80, 5, static_cast<std::uint64_t>(i)));
  });
  add("chunks_of_one_crown", {1, 300, 0}, [](Pack& p) {
    const int root = p.node("RootNode", -1);
    p.part("Object_2", trunk_part(5), {}, root);
    for (int i = 3; i <= 5; ++i) p.part("Object_" + std::to_string(i), crown_part(100, 5, static_cast<std::uint64_t>(i)), {}, root);
  });
  add("limbs_with_leaves", {1, 240, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(5));
    for (int i = 1; i <= 4; ++i) {
      const float angle = 1.5f * static_cast<float>(i);
      const glm::vec3 lean(1.5f * std::cos(angle), 0, 1.5f * std::sin(angle));
      p.part("branch" + std::to_string(i), {{"bark", post(1.5f, 0.1f, {0, 2, 0}, lean)}});
      p.part("leaves" + std::to_string(i), {{"leaf", leaves(60, glm::vec3(0, 3.5f, 0) + lean, glm::vec3(0.6f), 0.1f, 9)}});
    }
  });
  add("rings_of_a_rosette", {1, 160, 0}, [](Pack& p) {
    for (int i = 0; i < 4; ++i)
      p.part("Circle.00" + std::to_string(i),
             {{"leaf", leaves(40, {0, 0.2f, 0}, {0.3f + 0.1f * static_cast<float>(i), 0.2f, 0.3f}, 0.05f, static_cast<std::uint64_t>(i))}});
  });
  add("fronds_from_one_spot", {1, 350, 0}, [](Pack& p) {
    for (int i = 0; i < 7; ++i) {
      const float angle = 0.9f * static_cast<float>(i);
      const glm::vec3 lean(std::cos(angle), 0, std::sin(angle));
      p.part("frond_" + std::to_string(i),
             {{"bark", post(1, 0.03f, {}, lean)},
              {"leaf", leaves(50, 0.7f * lean + glm::vec3(0, 0.7f, 0), {0.3f, 0.3f, 0.3f}, 0.06f, static_cast<std::uint64_t>(i))}});
    }
  });
  add("layers_of_a_conifer", {1, 280, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(6));
    for (int i = 0; i < 4; ++i)
      p.part("layer" + std::to_string(i),
             {{"bark", post(0.3f, 0.1f, {0, 1.0f + static_cast<float>(i), 0})},
              {"leaf", leaves(70, {0, 1.2f + static_cast<float>(i), 0},
                              {1.5f - 0.3f * static_cast<float>(i), 0.3f, 1.5f - 0.3f * static_cast<float>(i)}, 0.1f, 5)}});
  });
  add("leaves_called_billboards", {1, 40, 0}, [](Pack& p) {
    p.part("palm_trunk", {{"bark", post(5, 0.4f, {}, {}, 100)}});
    p.part("leaf_billboards", crown_part(40, 5, 1));
  });
  add("potted_plant", {1, 90, 0}, [](Pack& p) {
    p.part("pot", {{"clay pot", post(0.3f, 0.4f)}});
    p.part("soil", {{"soil", plate(0.3f)}}, {0, 0.28f, 0});
    p.part("stems", {{"bark", post(1, 0.03f)}});
    p.part("leaves", crown_part(90, 1.2f, 2));
  });
  add("blades_of_a_tuft", {1, 40, 0}, [](Pack& p) {
    for (int i = 0; i < 40; ++i) {
      const float angle = 0.7f * static_cast<float>(i), r = 0.02f * static_cast<float>(i);
      Shape blade;
      blade.add_quad({glm::vec3(0), {0.02f, 0, 0}, {0.02f, 0.5f, 0.001f * static_cast<float>(i)}, {0, 0.5f, 0.1f}});
      p.part("Plane." + std::to_string(100 + i), {{"leaf", blade}}, {r * std::cos(angle), 0, r * std::sin(angle)});
    }
  });
  add("culms_of_bamboo", {1, 300, 0}, [](Pack& p) {
    for (int i = 0; i < 6; ++i)
      p.part("culm_" + std::to_string(i),
             {{"bark", post(6, 0.1f)}, {"leaf", leaves(50, {0, 4, 0}, {0.3f, 2, 0.3f}, 0.1f, static_cast<std::uint64_t>(i))}},
             {0.7f * static_cast<float>(i % 3), 0, 0.7f * static_cast<float>(i / 3)});
  });
  add("only_one_level", {1, 200, 0}, [](Pack& p) {
    p.part("oak_LOD1", tree(200, 5, 1));
    p.part("acorns", {{"acorn", post(0.1f, 0.05f, {0.5f, 3, 0})}});
  });
  add("branch_levels", {1, 200, 0}, [](Pack& p) {
    p.part("branch_L0", trunk_part(5));
    p.part("branch_L1", {{"bark", post(2, 0.2f, {0, 2, 0}, {1, 0, 0}, 20)}});
    p.part("branch_L2", {{"bark", post(1, 0.1f, {0, 3, 0}, {0, 0, 1}, 40)}});
    p.part("foliage", crown_part(200, 5, 1));
  });
  add("pot_and_plant_of_two_materials_each", {1, 80, 0}, [](Pack& p) {
    p.part("Plant_1", {{"clay", post(0.4f, 0.4f)}, {"soil", plate(0.3f)}});
    p.part("Plant_2", {{"stem", post(1, 0.03f)}, {"leaf", leaves(80, {0, 0.6f, 0}, {0.4f, 0.5f, 0.4f}, 0.1f, 1)}});
  });
  add("bush_of_three_bushes", {1, 180, 0}, [](Pack& p) {
    for (int i = 0; i < 3; ++i)
      p.part("Bush_" + std::to_string(i), crown_part(60, 2, static_cast<std::uint64_t>(i)),
             {0.15f * static_cast<float>(i), 0, 0.1f * static_cast<float>(i % 2)});
  });
  add("two_trunks_and_a_node_for_each_leaf", {1, 60, 0}, [](Pack& p) {
    p.part("elm_1", {{"bark", post(3, 0.2f)}});
    p.part("elm_2", {{"bark", post(3, 0.2f)}}, {1.5f, 0, 0});
    for (int i = 0; i < 60; ++i) {
      const float angle = 2.4f * static_cast<float>(i);
      Shape leaf;
      leaf.add_quad({glm::vec3(0), {0.2f, 0, 0}, {0.2f, 0.2f, 0.001f * static_cast<float>(i)}, {0, 0.2f, 0}});
      p.part("Plane." + std::to_string(i), {{"leaf", leaf}},
             {0.7f + std::cos(angle), 1.5f + 0.03f * static_cast<float>(i), std::sin(angle)});
    }
  });
  add("tulips", {1, 60, 0}, [](Pack& p) {
    for (int i = 0; i < 5; ++i) {
      const float angle = 1.3f * static_cast<float>(i);
      p.part("Object_" + std::to_string(i),
             {{"green", post(0.4f, 0.02f)}, {"leaf", leaves(12, {0, 0.2f, 0}, {0.03f, 0.2f, 0.03f}, 0.03f, 2)}},
             {0.12f * std::cos(angle), 0, 0.12f * std::sin(angle)});
    }
  });
  add("leaves_low_and_high_on_the_plant", {1, 290, 0}, [](Pack& p) {
    p.part("trunk", trunk_part(6));
    p.part("leaves_high", {{"leaf", leaves(200, {0, 5, 0}, {1, 1, 1}, 0.1f, 1)}});
    p.part("leaves_low", {{"leaf", leaves(90, {0, 2.5f, 0}, {1, 1, 1}, 0.1f, 2)}});
  });
  add("trunk_in_colours", {1, 200, 0}, [](Pack& p) {
    p.part("birch_trunk_col", trunk_part(5));
    p.part("birch_crown", crown_part(200, 5, 1));
  });
  return cases;
}

SourceContents contents_of(const Pack& pack, const ImportOptions& options = {}) {
  const TemporaryFolder folder;
  return must(bake::read_contents(write_file(folder / "pack.glb", pack.file.glb()), options));
}

class FileOfPlants : public testing::TestWithParam<Case> {};

TEST_P(FileOfPlants, GivesOnePlant) {
  Pack pack;
  GetParam().fill(pack);
  const Plant plant = imported(pack.file);
  const SourceContents contents = contents_of(pack);
  EXPECT_EQ(contents.variants.size(), GetParam().expected.variants);
  EXPECT_EQ(plant.leaves.size(), GetParam().expected.leaves);
  EXPECT_EQ(contents.left.size(), GetParam().expected.left) << bake::contents_table(contents);
  const bool is_told = !plant.warnings.empty() && plant.warnings.front() == bake::contents_line(contents);
  EXPECT_EQ(is_told, GetParam().expected.variants > 1 || GetParam().expected.left > 0);
}

std::string case_name(const testing::TestParamInfo<Case>& each) {
  return each.param.name;
}
INSTANTIATE_TEST_SUITE_P(Packs, FileOfPlants, testing::ValuesIn(packs()), case_name);
INSTANTIATE_TEST_SUITE_P(WholePlants, FileOfPlants, testing::ValuesIn(whole_plants()), case_name);

Pack issue_pack() {
  Pack pack;
  for (const Case& each : packs())
    if (each.name == "three_variants_with_levels_at_the_origin") each.fill(pack);
  return pack;
}

TEST(PlantChoice, TakesAnotherVariant) {
  Pack pack;
  for (int i = 0; i < 3; ++i)
    pack.part("oak_" + std::to_string(i + 1), tree(100 + i, 5, static_cast<std::uint64_t>(i)), {6.0f * static_cast<float>(i), 0, 0});
  ImportOptions options;
  options.plant.variant = 3;
  const Plant plant = imported(pack.file, options);
  EXPECT_EQ(plant.leaves.size(), 102u);
  EXPECT_EQ(contents_of(pack, options).taken, 2u);
  options.plant.variant = 4;
  expect_error(import_built(pack.file, options), Status::invalid_argument, {"4", "3", "'oak_1'", "'oak_2'", "'oak_3'"});
}

TEST(PlantChoice, TakesANodeByNameOrPattern) {
  const Pack pack = issue_pack();
  ImportOptions options;
  options.plant.node = "oak_B_LOD1";
  EXPECT_EQ(imported(pack.file, options).leaves.size(), 90u);
  options.plant.node = "^oak_B";
  EXPECT_EQ(imported(pack.file, options).leaves.size(), 300u);
  EXPECT_EQ(contents_of(pack, options).variants.size(), 1u);
  EXPECT_EQ(contents_of(pack, options).left.size(), 3u);
  options.plant.node = "elm";
  expect_error(import_built(pack.file, options), Status::invalid_argument, {"'elm'", "'oak_A_LOD0'"});
}

TEST(PlantChoice, TakesAllOfTheFile) {
  ImportOptions options;
  options.plant.whole = true;
  EXPECT_GE(imported(issue_pack().file, options).leaves.size(), 3u * 420u);
  EXPECT_TRUE(contents_of(issue_pack(), options).variants.empty());
}

TEST(PlantChoice, AHiddenPlantIsTakenByName) {
  Pack pack;
  pack.part("oak", tree(300, 5, 1));
  const int elm = pack.part("elm", tree(200, 5, 2));
  pack.file.node(elm)["extensions"]["KHR_node_visibility"]["visible"] = false;
  ImportOptions options;
  options.plant.node = "elm";
  EXPECT_EQ(imported(pack.file, options).leaves.size(), 200u);
  pack.file.node(elm)["extensions"]["KHR_node_visibility"]["visible"] = 1;
  expect_error(import_built(pack.file), Status::bad_file, {"nodes[1].extensions.KHR_node_visibility.visible"});
}

/// A level: rows of two species, each of a trunk and leaves below a node, and ground.
Pack level(const std::function<std::string(int)>& oak_name) {
  Pack pack;
  pack.part("Terrain", {{"soil", plate(60)}});
  const int trees = pack.node("Trees", -1);
  const int trunk = pack.mesh(trunk_part(5)), crown = pack.mesh(crown_part(100, 5, 1)), fern = pack.mesh(crown_part(60, 2, 2));
  for (int i = 0; i < 4; ++i) {
    const glm::vec3 at(6.0f * static_cast<float>(i), 0, 0);
    const int oak = pack.node(oak_name(i), -1, at, trees);
    pack.node("trunk", trunk, {}, oak);
    pack.node("leaves", crown, {}, oak);
    pack.node("fern", fern, at + glm::vec3(0, 0, 4));
  }
  return pack;
}

TEST(PlantChoice, ALevelIsSaidToBeOne) {
  const auto numbered = [](int i) { return i == 0 ? std::string("oak") : "oak.00" + std::to_string(i); };
  const SourceContents contents = contents_of(level(numbered));
  EXPECT_EQ(contents.copied_plant, "oak");
  EXPECT_EQ(contents.copy_count, 8u);
  const Plant plant = imported(level(numbered).file);
  ASSERT_FALSE(plant.warnings.empty());
  EXPECT_TRUE(mentions(plant.warnings.front(), {"8", "coppice scene", "--plants", "--node 'oak'"}));
  for (const Case& each : whole_plants()) {
    Pack pack;
    each.fill(pack);
    EXPECT_EQ(contents_of(pack).copied_plant, "") << each.name;
  }
}

TEST(PlantChoice, OfCopiesOfOneNameTheFirstIsTaken) {
  ImportOptions options;
  options.plant.node = "oak";
  EXPECT_EQ(imported(level([](int) { return "oak"; }).file, options).leaves.size(), 100u);
  options.plant.node = "^oak";
  EXPECT_EQ(imported(level([](int i) { return "oak " + std::to_string(i); }).file, options).leaves.size(), 100u);
}

TEST(Variants, HaveNamesWithoutLevelsAndOfPlants) {
  Pack pack;
  add_three_levels(pack, "oak_A", 5, 1, {0, 0, 0});
  add_three_levels(pack, "oak_B", 5, 2, {6, 0, 0});
  SourceContents contents = contents_of(pack);
  ASSERT_EQ(contents.variants.size(), 2u);
  EXPECT_EQ(contents.variants[0].name, "oak_A");
  EXPECT_EQ(contents.variants[1].name, "oak_B");
  Pack wrapped;
  for (int i = 0; i < 2; ++i) {
    const glm::vec3 at(6.0f * static_cast<float>(i), 0, 0);
    const int object = wrapped.node("Object_" + std::to_string(4 + i), -1, at);
    wrapped.part(i == 0 ? "Birch_bark" : "Larch_bark", trunk_part(5, static_cast<std::uint64_t>(i)), {}, object);
    wrapped.part(i == 0 ? "Birch_leaves" : "Larch_leaves", crown_part(100 + i, 5, 1), {}, object);
  }
  contents = contents_of(wrapped);
  ASSERT_EQ(contents.variants.size(), 2u);
  EXPECT_EQ(contents.variants[0].name, "Birch");
  EXPECT_EQ(contents.variants[1].name, "Larch");
}

TEST(PlantChoice, LevelsHaveTwoDigitsAndCopiesMayHaveThree) {
  EXPECT_EQ(bake::read_node_name("oak_lod_12").level, 12u);
  EXPECT_FALSE(bake::read_node_name("oak_lod_100").level);
  EXPECT_FALSE(bake::read_node_name("oak_L100").weak_level);
  EXPECT_EQ(bake::without_level("oak_B_LOD0"), "oak_B");
  EXPECT_EQ(bake::without_level("Oak (LOD 1).002"), "Oak");
  EXPECT_EQ(bake::without_level("oak_02"), "oak_02");
  EXPECT_EQ(bake::without_level("LOD2"), "");
}

TEST(PlantChoice, ABadLevelListIsRefused) {
  Pack pack;
  const int node = pack.part("oak", tree(20, 5, 1));
  pack.file.node(node)["extensions"]["MSFT_lod"]["ids"] = {7};
  expect_error(import_built(pack.file), Status::bad_file, {"nodes[0].extensions.MSFT_lod.ids"});
}

TEST(Variants, OutputsDifferInMoreThanCase) {
  SourceContents contents;
  for (const char* name : {"Oak", "oak", "OAK", "Plants", "a/b", "a:b"}) contents.variants.push_back({.name = name});
  const auto outputs = bake::variant_outputs("baked/plants.coppice", contents);
  EXPECT_EQ(outputs,
            (std::vector<std::filesystem::path>{"baked/plants_Oak.coppice", "baked/plants_oak_2.coppice", "baked/plants_OAK_3.coppice",
                                                "baked/plants.coppice", "baked/plants_a_b.coppice", "baked/plants_a_b_2.coppice"}));
}

}  // namespace coppice::test::gltf_variants_test
