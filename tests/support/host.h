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

#include "coppice/coppice.h"
#include "places.h"
#include "vectors.h"

namespace coppice::test {

inline const std::string kPlants = (std::string(test::kTestData) + "/plants/");

using ChunkName = std::tuple<std::uint32_t, coppice_streamed, std::uint32_t>;

inline ChunkName name_of(const coppice_change& change) {
  return {change.file, change.chunk, change.index};
}

/// Hooks that run inline, so that a frame is the same each time.
inline void run_now(void*, void (*function)(void*), void* argument) {
  function(argument);
}

class Host {
 public:
  explicit Host(std::uint64_t budget_bytes = 64u << 20) {
    coppice_jobs jobs;
    coppice_jobs_init(&jobs);
    jobs.submit = run_now;
    coppice_context_desc desc;
    coppice_context_desc_init(&desc);
    desc.jobs = &jobs;
    desc.memory_budget_bytes = budget_bytes;
    desc.streaming_ms = 1000.0f;
    EXPECT_EQ(coppice_context_create(&desc, &context_), COPPICE_OK) << coppice_last_error(nullptr);
    coppice_view_desc view;
    coppice_view_desc_init(&view);
    EXPECT_EQ(coppice_view_create(context_, &view, &view_), COPPICE_OK);
    coppice_camera_init(&camera_);
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
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = ++number_;
    frame.completed_number = number_ - 1;
    frame.cameras = &camera_;
    frame.camera_count = 1;
    frame.wind = wind;
    EXPECT_EQ(coppice_frame_begin(context_, &frame), COPPICE_OK) << coppice_last_error(context_);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // reads come back
  }
  coppice_change next() {
    coppice_change change;
    coppice_change_init(&change);
    EXPECT_EQ(coppice_next_change(context_, &change), COPPICE_OK) << coppice_last_error(context_);
    return change;
  }
  coppice_status confirm(const coppice_change& change, coppice_outcome outcome) { return coppice_confirm(context_, &change, outcome); }
  /// Takes and frees everything; keeps what was added and the bytes of pages.
  void take_all() {
    for (coppice_change change = next(); change.kind != COPPICE_CHANGE_NONE; change = next()) {
      if (change.kind == COPPICE_CHANGE_CHUNK_ADDED) {
        EXPECT_TRUE(there.insert(name_of(change)).second);
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
        EXPECT_EQ(there.erase(name_of(change)), 1u);
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
    coppice_plant_info info;
    coppice_plant_info_init(&info);
    EXPECT_EQ(coppice_plant_get_info(context_, plant, &info), COPPICE_OK);
    return info;
  }
  coppice_stats stats() {
    coppice_stats stats;
    coppice_stats_init(&stats);
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

  std::set<ChunkName> there;
  std::map<std::uint32_t, int> files;
  std::vector<coppice_leaf_node> nodes;  ///< from node 1 on, of the one plant

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
  coppice_camera camera_{};
  std::uint64_t number_ = 0;
};

}  // namespace coppice::test
