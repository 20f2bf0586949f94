#pragma once

// A host that draws itself, for tests: what it hears, what it confirms, what it is told to draw.

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "abi.h"
#include "coppice/coppice.h"
#include "places.h"
#include "vectors.h"

namespace coppice::test {

inline const std::string kPlants = std::string(test::kTestData) + "/plants/";

class Host {
 public:
  explicit Host(std::uint64_t budget_bytes = 64u << 20) {
    auto jobs = struct_defaults<coppice_jobs>();
    jobs.submit = [](void*, const coppice_job* job) { job->function(job->argument); };  // inline: a frame is the same each time
    auto desc = struct_defaults<coppice_context_desc>();
    desc.jobs = &jobs;
    desc.memory_budget_bytes = budget_bytes;
    desc.streaming_ms = 1000.0f;
    EXPECT_EQ(coppice_context_create(&desc, &context_), COPPICE_OK) << coppice_last_error(nullptr);
    const auto view = struct_defaults<coppice_view_desc>();
    EXPECT_EQ(coppice_view_create(context_, &view, &view_), COPPICE_OK);
    camera_.view = view_;
    camera_.width_px = camera_.height_px = 512;
    camera_.clip_from_view[10] = camera_.clip_from_view[15] = 0.0f;
    camera_.clip_from_view[11] = -1.0f;
    camera_.clip_from_view[14] = 0.1f;
    camera_.error_px = 0.01f;
  }
  ~Host() { coppice_context_destroy(context_); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  coppice_context* context() { return context_; }
  coppice_view view() const { return view_; }
  coppice_camera& camera() { return camera_; }
  const coppice_wind* wind = nullptr;  ///< what frames begin with

  coppice_plant open(const char* name) {
    coppice_plant plant = 0;
    EXPECT_EQ(coppice_plant_open(context_, (kPlants + name).c_str(), &plant), COPPICE_OK) << coppice_last_error(context_);
    return plant;
  }
  coppice_instance add(coppice_plant plant, float x, float z, float scale = 1.0f) {
    const coppice_placement placement{{x, -1.0f, z}, scale, {0, 0, 0, 1}, {1, 1, 1}, 0, COPPICE_ALL_LAYERS, 0, 1};
    coppice_instance instance = 0;
    EXPECT_EQ(coppice_instances_add(context_, plant, &placement, sizeof placement, 1, &instance), COPPICE_OK);
    return instance;
  }
  void frame() {
    auto frame = struct_defaults<coppice_frame>();
    frame.frame_number = ++number_;
    frame.completed_number = number_ - 1;
    frame.cameras = &camera_;
    frame.camera_count = 1;
    frame.wind = wind;
    EXPECT_EQ(coppice_frame_begin(context_, &frame), COPPICE_OK) << coppice_last_error(context_);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // reads come back
  }
  coppice_change next() {
    auto change = struct_defaults<coppice_change>();
    EXPECT_EQ(coppice_next_change(context_, &change), COPPICE_OK) << coppice_last_error(context_);
    return change;
  }
  coppice_status confirm(const coppice_change& change, coppice_outcome outcome) { return coppice_confirm(context_, &change, outcome); }
  /// Takes and frees everything; keeps what was added and the bytes of pages.
  void take_all() {
    for (coppice_change change = next(); change.kind != COPPICE_CHANGE_NONE; change = next()) {
      const std::tuple name{change.file, change.chunk, change.index};
      if (change.kind == COPPICE_CHANGE_CHUNK_ADDED) {
        EXPECT_TRUE(there.insert(name).second);
        if (change.chunk == COPPICE_STREAMED_PAGES) {
          std::vector<coppice_leaf_node> of_page(change.node_count);
          EXPECT_EQ(change.byte_count, of_page.size() * sizeof of_page[0]);
          EXPECT_EQ(change.first_node, nodes.size() + 1) << "pages come in order";
          std::memcpy(of_page.data(), change.bytes, change.byte_count);
          nodes.insert(nodes.end(), of_page.begin(), of_page.end());
        }
        if (change.chunk == COPPICE_STREAMED_WOOD) take_wood(change);
        EXPECT_EQ(confirm(change, COPPICE_OUTCOME_TAKEN), COPPICE_OK);
      } else if (change.kind == COPPICE_CHANGE_CHUNK_DROPPED) {
        EXPECT_EQ(there.erase(name), 1u);
        EXPECT_EQ(confirm(change, COPPICE_OUTCOME_FREED), COPPICE_OK);
      } else {
        files[change.file] += change.kind == COPPICE_CHANGE_PLANT_OPENED ? 1 : -1;
      }
    }
  }
  /// Frames until nothing more comes.
  void settle() {
    for (int i = 0; i < 200; ++i) {
      frame();
      take_all();
      std::uint32_t settled = 0;
      EXPECT_EQ(coppice_is_settled(context_, view_, &settled), COPPICE_OK);
      if (settled == COPPICE_TRUE && i > 2) return;
    }
    ADD_FAILURE() << "does not settle";
  }
  coppice_plant_info info(coppice_plant plant) {
    auto info = struct_defaults<coppice_plant_info>();
    EXPECT_EQ(coppice_plant_get_info(context_, plant, &info), COPPICE_OK);
    return info;
  }
  coppice_stats stats() {
    auto stats = struct_defaults<coppice_stats>();
    EXPECT_EQ(coppice_get_stats(context_, &stats), COPPICE_OK);
    return stats;
  }
  std::vector<coppice_draw> draws() {
    std::uint32_t count = 0;
    EXPECT_EQ(coppice_get_draws(context_, view_, nullptr, 0, sizeof(coppice_draw), &count), COPPICE_OK) << coppice_last_error(context_);
    std::vector<coppice_draw> draws(count);
    EXPECT_EQ(coppice_get_draws(context_, view_, draws.data(), count, sizeof(coppice_draw), &count), COPPICE_OK);
    return draws;
  }

  std::set<std::tuple<std::uint32_t, coppice_streamed, std::uint32_t>> there;  ///< chunks: file, kind, index
  std::map<std::uint32_t, int> files;
  std::vector<coppice_leaf_node> nodes;   ///< from node 1 on, of the one plant
  std::vector<std::array<vec3, 3>> wood;  ///< triangles of the wood that came last; object space

 private:
  void take_wood(const coppice_change& change) {
    const auto* vertices = static_cast<const coppice_mesh_vertex*>(change.bytes);
    const auto* indices = reinterpret_cast<const std::uint32_t*>(vertices + change.vertex_count);
    wood.clear();
    for (std::uint32_t i = 0; i + 2 < change.index_count; i += 3) {
      const auto place = [&](std::uint32_t k) { return vec3(vertices[indices[i + k]].position); };
      wood.push_back({place(0), place(1), place(2)});
    }
  }

  coppice_context* context_ = nullptr;
  coppice_view view_ = 0;
  coppice_camera camera_ = struct_defaults<coppice_camera>();
  std::uint64_t number_ = 0;
};

}  // namespace coppice::test
