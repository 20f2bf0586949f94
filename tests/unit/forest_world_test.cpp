// The demo's world: planting, ground, camera paths.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include "camera.h"
#include "failure.h"
#include "frame_pace.h"
#include "mentions.h"
#include "options.h"
#include "output.h"
#include "placement.h"
#include "statistics.h"
#include "terrain.h"
#include "tufts.h"
#include "watch.h"

namespace forest::forest_world_test {

Options parsed(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "coppice-forest");
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  const ParsedOptions parsed = parse_options(static_cast<int>(argv.size()), argv.data());
  EXPECT_FALSE(parsed.exit_code);
  return parsed.options;
}

TEST(Options, OnePlantIsLookedAtFromAllSidesAndWhatIsNotSaidIsLeftToTheDevice) {
  const Options one = parsed({"oak.coppice"});
  EXPECT_EQ(one.plants, std::vector<std::string>{"oak.coppice"});
  EXPECT_EQ(one.count, 1u);
  EXPECT_EQ(one.camera, "turntable");
  EXPECT_EQ(one.fog, 0);
  EXPECT_EQ(parsed({"--count", "1"}).camera, "turntable");
  const Options forest = parsed({"oak.coppice", "--count", "50", "--fog", "2"});
  EXPECT_EQ(forest.count, 50u);
  EXPECT_EQ(forest.camera, "walk");
  EXPECT_EQ(forest.fog, 2);
  EXPECT_EQ(parsed({testing::TempDir()}).count, Options{}.count) << "a folder is a forest";
  EXPECT_EQ(parsed({"oak.coppice", "--camera", "top"}).camera, "top");
  EXPECT_FALSE(one.render_scale || one.temporal || one.leaf_budget || one.frames);
  const Options said = parsed({"--taa", "--no-shadows"});
  EXPECT_EQ(said.temporal, true);
  EXPECT_TRUE(one.shadows && !said.shadows);
}

TEST(Watch, SeesAChangedFileOnceAndOnlyWhenItIsWhole) {
  const std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("watch_test_" + std::to_string(::getpid()));
  const auto write = [&](const char* text) { std::ofstream(path) << text; };
  write("one");
  Watch watch = watch_files({path.string(), path.string() + ".missing"});
  EXPECT_TRUE(changed_files(watch).empty());
  write("three");
  EXPECT_TRUE(changed_files(watch).empty()) << "it may still be being written";
  EXPECT_EQ(changed_files(watch), std::vector<std::size_t>{0});
  EXPECT_TRUE(changed_files(watch).empty());
  std::filesystem::remove(path);
  EXPECT_TRUE(changed_files(watch).empty()) << "a missing file has not changed";
  write("seventeen");
  EXPECT_TRUE(changed_files(watch).empty());
  EXPECT_EQ(changed_files(watch), std::vector<std::size_t>{0});
  std::filesystem::remove(path);
}

const std::vector<Species> kSpecies = {{2.0f}, {4.5f}, {0.2f}};

TEST(FramePace, MovesByLittleAndRestsNearTheAim) {
  // Frames take 10 ms and 100 ns a leaf.
  FramePace pace{.aim_ms = 33, .scales = false};
  for (int i = 0; i < 400; ++i) {
    const float last = pace.budget;
    keep_pace(pace, 10.0f + 1e-4f * last, true);
    EXPECT_NEAR(pace.budget / (i > 0 ? last : pace.budget), 1.0f, 0.051f) << i;
  }
  EXPECT_NEAR(10.0f + 1e-4f * pace.budget, 33.0f, 3.5f);
  const float at_rest = pace.budget;
  keep_pace(pace, 31.0f, true);
  EXPECT_EQ(pace.budget, at_rest);
}

TEST(FramePace, DoesNotGrowWhereThatWouldChangeNothing) {
  const FramePace pace{.aim_ms = 33, .scales = false, .budget = 100'000};
  FramePace fast = pace;
  for (int i = 0; i < 100; ++i) keep_pace(fast, 5, false);
  EXPECT_EQ(fast.budget, pace.budget);
}

/// A machine whose frames take so long: some of it for pixels, some for leaves.
float frame_ms_of(const FramePace& pace) {
  const float leaves = pace.budget > 0 ? pace.budget : 4e6f;
  return 6 + 120 * pace.scale * pace.scale + 2e-5f * leaves;
}

FramePace paced(FramePace pace, bool limited) {
  for (int frame = 0; frame < 1000; ++frame) keep_pace(pace, frame_ms_of(pace), limited);
  return pace;
}

TEST(FramePace, DrawsFewerPixelsAndOnlyThenFewerLeaves) {
  const FramePace slow = paced({.aim_ms = 60, .budget = 1e6f}, false);
  EXPECT_LE(frame_ms_of(slow), 60);
  EXPECT_GT(frame_ms_of(slow), 45);
  EXPECT_GT(slow.scale, kLeastScale);
  EXPECT_EQ(slow.budget, 1e6f);

  const FramePace slower = paced({.aim_ms = 20, .budget = 1e6f}, true);
  EXPECT_LE(frame_ms_of(slower), 20);
  EXPECT_EQ(slower.scale, kLeastScale);
  EXPECT_LT(slower.budget, 1e6f);
  FramePace again = slower;
  again.aim_ms = 1000;
  EXPECT_EQ(paced(again, false).scale, 1) << "it comes back";
}

TEST(FramePace, KeepsWhatWasAskedFor) {
  const FramePace still = paced({.scale = 0.4f, .budget = 5}, true);
  EXPECT_EQ(still.scale, 0.4f);
  EXPECT_EQ(still.budget, 5);
  const FramePace leaves = paced({.aim_ms = 60, .scale = 0.5f, .scales = false}, true);
  EXPECT_EQ(leaves.scale, 0.5f);
  EXPECT_LE(frame_ms_of(leaves), 60);
  EXPECT_EQ(stepped_scale(leaves), 0.5f);
}

TEST(FramePace, AFrameStartsAPeriodAfterTheLastOrAtOnce) {
  EXPECT_EQ(next_start(100, 103, 16), 116);
  EXPECT_EQ(next_start(100, 130, 16), 130) << "a late frame is not made up for";
}

TEST(Placement, PlantsExactlyTheCountInsideTheSquare) {
  for (std::uint32_t count : {1u, 7u, 2000u}) {
    const Planting planting = plant_forest(kSpecies, count, 3);
    EXPECT_EQ(planting.plants.size(), count);
    for (const PlacedPlant& plant : planting.plants) {
      EXPECT_LE(std::abs(plant.position.x), planting.half_extent_m);
      EXPECT_LE(std::abs(plant.position.y), planting.half_extent_m);
      EXPECT_LT(plant.species, kSpecies.size());
    }
  }
}

TEST(Placement, OnePlantStandsInTheMiddleAsItIs) {
  const Planting planting = plant_forest(std::vector<Species>{{3.0f}}, 1, 5);
  ASSERT_EQ(planting.plants.size(), 1u);
  EXPECT_EQ(planting.plants[0].position, glm::vec2(0));
  EXPECT_EQ(planting.plants[0].scale, 1.0f);
  EXPECT_EQ(planting.plants[0].tint, glm::vec3(1));
}

TEST(Placement, AQuarterIsYoungAndStandsInThickets) {
  const Planting planting = plant_forest(kSpecies, 2000, 4);
  std::vector<glm::vec2> young;
  for (const PlacedPlant& plant : planting.plants)
    if (plant.scale < 0.6f * fitting_scale(kSpecies[plant.species].radius_m)) young.push_back(plant.position);
  EXPECT_EQ(young.size(), 500u);
  for (std::uint32_t s = 0; s < kSpecies.size(); ++s) EXPECT_GT(std::ranges::count(planting.plants, s, &PlacedPlant::species), 50) << s;
  // Nearer to the next one than as many would be that were strewn evenly.
  float nearest_m = 0;
  for (std::size_t i = 0; i < young.size(); ++i) {
    float of_this_m = 1e9f;
    for (std::size_t j = 0; j < young.size(); ++j)
      if (i != j) of_this_m = std::min(of_this_m, glm::distance(young[i], young[j]));
    nearest_m += of_this_m / static_cast<float>(young.size());
  }
  EXPECT_LT(nearest_m, 0.45f * 2 * planting.half_extent_m / std::sqrt(static_cast<float>(young.size())));
}

TEST(Placement, NothingStandsOnTheTrailOrInAnotherStem) {
  const Planting planting = plant_forest(kSpecies, 600, 5);
  for (std::size_t i = 0; i < planting.plants.size(); ++i) {
    const PlacedPlant& plant = planting.plants[i];
    EXPECT_GT(distance_from(planting.trail, plant.position), 1.0f) << i;
    for (std::size_t j = 0; j < i; ++j) {
      const PlacedPlant& other = planting.plants[j];
      EXPECT_GT(glm::distance(plant.position, other.position), 0.5f * (plant.crown_radius_m + other.crown_radius_m)) << i << " " << j;
    }
  }
}

TEST(Placement, IsAFunctionOfItsSeed) {
  const Planting a = plant_forest(kSpecies, 300, 9), b = plant_forest(kSpecies, 300, 9), c = plant_forest(kSpecies, 300, 10);
  bool differs = false;
  for (std::size_t i = 0; i < a.plants.size(); ++i) {
    EXPECT_EQ(a.plants[i].position, b.plants[i].position);
    EXPECT_EQ(a.plants[i].scale, b.plants[i].scale);
    differs |= a.plants[i].position != c.plants[i].position;
  }
  EXPECT_TRUE(differs);
}

TEST(Trail, PointsAreOnItAndItCloses) {
  const Trail trail = make_trail(80, 1);
  const float total_m = length_m(trail);
  for (float at_m = -total_m; at_m < 2 * total_m; at_m += 3.7f) EXPECT_LT(distance_from(trail, point_on(trail, at_m)), 1e-3f) << at_m;
  EXPECT_LT(glm::distance(point_on(trail, 0), point_on(trail, total_m)), 1e-3f);
}

TEST(Terrain, HeightIsThatOfTheDrawnTriangles) {
  const Terrain terrain = make_terrain(80, 1);
  for (std::size_t i = 0; i + 2 < terrain.indices.size(); i += 3 * 97) {
    glm::vec3 middle(0);
    for (std::size_t corner = 0; corner < 3; ++corner) middle += terrain.vertices[terrain.indices[i + corner]].position / 3.0f;
    EXPECT_NEAR(height_at(terrain, middle.x, middle.z), middle.y, 1e-3f) << i;
  }
}

TEST(Terrain, ChunksCoverEveryTriangleAndBoundTheirVertices) {
  const Terrain terrain = make_terrain(80, 1);
  std::size_t next = 0;
  for (const TerrainChunk& chunk : terrain.chunks) {
    ASSERT_EQ(chunk.first_index, next);
    next += chunk.index_count;
    for (std::uint32_t i = chunk.first_index; i < next; ++i) {
      const glm::vec3 position = terrain.vertices[terrain.indices[i]].position;
      ASSERT_TRUE(glm::all(glm::greaterThanEqual(position, chunk.box_min)) && glm::all(glm::lessThanEqual(position, chunk.box_max)));
    }
  }
  EXPECT_EQ(next, terrain.indices.size());
}

TEST(Camera, ClipSpaceIsReversedAndPointsDown) {
  Pose pose;
  pose.position = {1, 2, 3};
  const glm::mat4 clip_from_world = clip_from_view(pose, 1.5f) * view_from_world(pose);
  const auto project = [&](glm::vec3 at) {
    const glm::vec4 clip = clip_from_world * glm::vec4(at, 1);
    return glm::vec3(clip) / clip.w;
  };
  const float nearer = project(pose.position + 1.0f * forward(pose)).z, farther = project(pose.position + 100.0f * forward(pose)).z;
  EXPECT_GT(nearer, farther);
  EXPECT_GT(farther, 0);
  EXPECT_LT(nearer, 1);
  EXPECT_LT(project(pose.position + glm::vec3(0, 1, -10)).y, 0) << "up is -y in Vulkan's clip space";
  EXPECT_GT(project(pose.position + glm::vec3(1, 0, -10)).x, 0);
}

/// How far the box reaches in the picture, of 1 at its edge; 9 where a corner is behind the camera.
float reach_of(const Box& box, const Pose& pose, float aspect) {
  float reach = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 at(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z);
    const glm::vec4 clip = clip_from_view(pose, aspect) * view_from_world(pose) * glm::vec4(at, 1);
    reach = std::max({reach, std::abs(clip.x / clip.w), std::abs(clip.y / clip.w), clip.w > 0 ? 0 : 9.0f});
  }
  return reach;
}

TEST(Camera, OnePlantFillsThePictureAndIsAllInIt) {
  const Terrain terrain = make_terrain(30, 1);
  const Box tall{{-1, 0, -2}, {3, 12, 1}}, flat{{-4, 0, -4}, {4, 0.3f, 4}}, point{{0, 1, 0}, {0, 1, 0}};
  for (const Box& box : {tall, flat, point})
    for (const float aspect : {0.5f, 1.0f, 2.4f}) {
      float most = 0;
      const CameraPath turn = turntable_path(box, aspect, terrain);
      for (double time_s = 0; time_s < turn.duration_s; time_s += 0.37) most = std::max(most, reach_of(box, turn.pose(time_s), aspect));
      EXPECT_LT(glm::distance(turn.pose(0).position, turn.pose(turn.duration_s).position), 1e-3f);
      for (const float reach : {most, reach_of(box, front_path(box, aspect, terrain).pose(0), aspect),
                                reach_of(box, top_path(box, aspect, terrain).pose(0), aspect)}) {
        EXPECT_LT(reach, 1) << aspect;
        EXPECT_TRUE(reach > 0.7f || box.min == box.max) << aspect;
      }
    }
}

TEST(Camera, FramesAreSpreadOverThePathOrComeAsOftenAsAUsersDo) {
  CameraPath path;
  path.duration_s = 10;
  EXPECT_EQ(frame_time_s(path, 0, 5, 0), 0);
  EXPECT_EQ(frame_time_s(path, 4, 5, 0), 10);
  EXPECT_EQ(frame_time_s(path, 0, 1, 0), 10);
  EXPECT_DOUBLE_EQ(frame_time_s(path, 8, 9, 4), 2);
  EXPECT_EQ(frame_time_s(path, 48, 49, 4), 10);
  path.loops = true;
  EXPECT_DOUBLE_EQ(frame_time_s(path, 48, 49, 4), 2);
}

TEST(Camera, TopLooksStraightDownWithTheFrontBelow) {
  const Terrain terrain = make_terrain(30, 1);
  const Box box{{-1, 0, -1}, {1, 2, 1}};
  const Pose pose = top_path(box, 1, terrain).pose(0);
  const glm::vec4 front = clip_from_view(pose, 1) * view_from_world(pose) * glm::vec4(0, 2, 1, 1);
  EXPECT_GT(front.y / front.w, 0.1f) << "+Z at the lower edge";
  EXPECT_NEAR(front.x, 0, 1e-4f);
}

TEST(Camera, TheWalkKeepsToTheTrailAtEyeHeightAndCloses) {
  const Terrain terrain = make_terrain(80, 1);
  const Trail trail = make_trail(80, 1);
  const CameraPath path = walk_path(trail, terrain);
  for (double time_s = 0; time_s < path.duration_s; time_s += 0.9) {
    const Pose pose = path.pose(time_s);
    EXPECT_LT(distance_from(trail, {pose.position.x, pose.position.z}), 0.9f) << time_s;
    EXPECT_NEAR(pose.position.y - height_at(terrain, pose.position.x, pose.position.z), 1.7f, 1e-3f) << time_s;
  }
  EXPECT_LT(glm::distance(path.pose(0).position, path.pose(path.duration_s).position), 1e-2f);
}

/// A keyframe file that is removed with the test.
struct KeyframeFile {
  std::filesystem::path path = std::filesystem::path(testing::TempDir()) / ("forest_world_test_" + std::to_string(getpid()) + ".camera");
  explicit KeyframeFile(const std::string& text) { std::ofstream(path) << text; }
  ~KeyframeFile() { std::filesystem::remove(path); }
};

TEST(Camera, KeyframesAreMetAtTheirTimes) {
  const Terrain terrain = make_terrain(80, 1);
  const KeyframeFile file("# a comment\n10 1 2 3 90 -10\n\n12 5 2 3 180 0 30 # narrower\n16 9 4 3 180 0\n");
  const CameraPath path = path_from_file(file.path.string(), terrain);
  EXPECT_DOUBLE_EQ(path.duration_s, 6);
  const Pose first = path.pose(0);
  EXPECT_NEAR(first.position.x, 1, 1e-4);
  EXPECT_NEAR(first.position.y, height_at(terrain, 1, 3) + 2, 1e-4);
  EXPECT_NEAR(first.yaw_rad, std::numbers::pi / 2, 1e-4);
  const Pose second = path.pose(2);
  EXPECT_NEAR(second.position.x, 5, 1e-4);
  EXPECT_NEAR(glm::degrees(second.fov_y_rad), 30, 1e-3);
  EXPECT_NEAR(path.pose(100).position.x, 9, 1e-4) << "after the last keyframe";
}

TEST(Camera, AWayThatWasRecordedIsPlayed) {
  const Terrain terrain = make_terrain(80, 1);
  const KeyframeFile file("");
  // Turns through 180 degrees, where a path's yaw jumps from one end of its range to the other.
  const auto pose_at = [&](float t) {
    Pose pose;
    pose.position = {2 * t, height_at(terrain, 2 * t, -t) + 1.5f, -t};
    pose.yaw_rad = std::remainder(3.0f + 0.2f * t, 2 * std::numbers::pi_v<float>);
    pose.pitch_rad = -0.1f;
    return pose;
  };
  PathRecorder recorder = start_recording(file.path.string());
  struct stat started {
  }, ended{};
  ASSERT_EQ(::stat(file.path.c_str(), &started), 0);
  for (int frame = 0; frame <= 120; ++frame) record_pose(recorder, frame / 60.0, pose_at(static_cast<float>(frame) / 60.0f), terrain);
  ASSERT_EQ(::stat(file.path.c_str(), &ended), 0);
  EXPECT_EQ(ended.st_ino, started.st_ino) << "it grows, and is not written anew";
  const CameraPath path = path_from_file(file.path.string(), terrain);
  EXPECT_NEAR(path.duration_s, 2, 0.3);
  for (const float t : {0.5f, 1.1f, 1.6f}) {
    const Pose expected = pose_at(t), played = path.pose(static_cast<double>(t));
    EXPECT_LT(glm::distance(expected.position, played.position), 0.05f);
    EXPECT_LT(glm::distance(forward(expected), forward(played)), 0.01f);
    EXPECT_NEAR(expected.fov_y_rad, played.fov_y_rad, 1e-4);
  }
  EXPECT_THROW(static_cast<void>(start_recording(file.path.string() + "/camera.txt")), Failure);
}

TEST(Output, OfWhatDoesNotFitNothingIsWritten) {
  const KeyframeFile file("old");
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto ignored = ::signal(SIGXFSZ, SIG_IGN);
  const rlimit less{200, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &less), 0);
  EXPECT_THROW(write_output(file.path.string(), std::string(201, 'x')), Failure);
  const GrowingOutput growing = start_output(file.path.string() + ".way", "start");
  add(growing, " and more");
  EXPECT_THROW(add(growing, std::string(201, 'x')), Failure);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  ::signal(SIGXFSZ, ignored);
  std::ifstream old(file.path), way(growing.file);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(old), {}), "old");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(way), {}).substr(0, 14), "start and more");
  std::filesystem::remove(growing.file);
  write_output("/dev/null", "gone");
  add(start_output("/dev/null", "gone"), "gone");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(Output, NoLinkOfAnotherUserInASharedFolderIsFollowed) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can act for another user";
  constexpr uid_t kOther = 4711;
  const KeyframeFile mine("mine");
  const std::filesystem::path folder = mine.path.string() + ".shared", link = folder / "stats.json";
  std::filesystem::create_directory(folder);
  std::filesystem::create_symlink(mine.path, link);
  std::filesystem::create_directory_symlink(mine.path.parent_path(), folder / "way");
  const std::string beyond = folder / "way" / mine.path.filename();
  write_output(beyond, "followed too");
  write_output(link, "followed");
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  std::filesystem::permissions(folder, std::filesystem::perms::all | std::filesystem::perms::sticky_bit);
  for (const std::filesystem::path& theirs : {link, folder / "way"}) ASSERT_EQ(::lchown(theirs.c_str(), kOther, kOther), 0);
  EXPECT_THROW(check_outputs(std::array{NamedOutput{"--stats", beyond}}, {}), Failure);
  EXPECT_THROW(write_output(beyond, "trapped"), Failure);
  write_output(link, "in its place");
  EXPECT_FALSE(std::filesystem::is_symlink(link));
  std::ifstream file(mine.path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "followed");
  std::filesystem::remove_all(folder);
}

TEST(Camera, ABadKeyframeFileNamesItsLine) {
  const Terrain terrain = make_terrain(80, 1);
  const auto failure_of = [&](const std::string& text) -> std::string {
    const KeyframeFile file(text);
    try {
      static_cast<void>(path_from_file(file.path.string(), terrain));
    } catch (const Failure& failure) {
      return failure.what();
    }
    return "accepted";
  };
  using coppice::test::mentions;
  for (const char* text : {"0 1 2 3 4 5\n1 2 3\n", "0 1 2 3 4 5\n0 1 2 3 4 5\n"}) EXPECT_TRUE(mentions(failure_of(text), {":2"}));
  EXPECT_TRUE(mentions(failure_of("0 1 2 3 4 5 60 7\n"), {":1", "7"}));
  EXPECT_TRUE(mentions(failure_of("0 1 2 3 4 5 sixty\n"), {":1", "sixty"}));
  EXPECT_TRUE(mentions(failure_of("0 1 2 3 4 5 600\n"), {":1", "fov_y_deg"}));
  EXPECT_TRUE(mentions(failure_of("0 nan 2 3 4 5\n"), {":1"}));
  EXPECT_NE(failure_of("# nothing\n"), "accepted");
  EXPECT_THROW(static_cast<void>(path_from_file("/nowhere/x.camera", terrain)), Failure);
}

TEST(Statistics, PercentilesAreByNearestRank) {
  std::vector<float> frame_ms;
  for (int i = 0; i < 100; ++i) frame_ms.push_back(static_cast<float>((i * 37) % 100 + 1));  // 1 to 100
  const FrameTimes hundred = summarize(frame_ms);
  EXPECT_EQ(hundred.median, 50);
  EXPECT_EQ(hundred.p95, 95);
  EXPECT_EQ(hundred.p99, 99);
  EXPECT_EQ(hundred.max, 100);
  const FrameTimes few = summarize({1, 9, 2});
  EXPECT_EQ(few.median, 2);
  EXPECT_EQ(few.p99, 9) << "the worst";
  EXPECT_EQ(summarize({}).max, 0);
}

TEST(Feet, AreWherePlantsStandAndNotUnderASingleOne) {
  const Planting planting = plant_forest(kSpecies, 400, 2);
  const Feet feet = make_feet(planting);
  ASSERT_EQ(feet.feet.size(), planting.plants.size());
  for (const PlacedPlant& plant : planting.plants) {
    EXPECT_FLOAT_EQ(foot_share(feet, plant.position), 1);
    EXPECT_LT(foot_share(feet, plant.position + glm::vec2(0.1f, 0)), 1);
  }
  EXPECT_EQ(foot_share(feet, point_on(planting.trail, 0)), 0);
  EXPECT_EQ(foot_share(make_feet(plant_forest(kSpecies, 1, 2)), {0, 0}), 0);
}

/// A forest as it is seen where the walk begins.
struct SeenForest {
  Planting planting = plant_forest(kSpecies, 400, 2);
  Terrain terrain = make_terrain(planting.half_extent_m, 2);
  Pose pose = walk_path(planting.trail, terrain).pose(0);
  glm::mat4 clip_from_world = clip_from_view(pose, 1.7f) * view_from_world(pose);
};

TEST(Feet, MoundsRiseFromTheGroundAndFaceUp) {
  const auto [planting, terrain, pose, clip_from_world] = SeenForest();
  std::vector<TerrainVertex> vertices(kMaxMounds * kMoundVertices);
  vertices.resize(gather_mounds(terrain, make_feet(planting), clip_from_world, pose.position, vertices) * kMoundVertices);
  ASSERT_GT(vertices.size(), 0u);
  for (const TerrainVertex& vertex : vertices) {
    const float above_m = vertex.position.y - height_at(terrain, vertex.position.x, vertex.position.z);
    EXPECT_GT(above_m, -0.04f);
    EXPECT_LT(above_m, 0.8f);
    EXPECT_GT(vertex.normal.y, 0);
    EXPECT_TRUE(vertex.foot != 0 || above_m < 0) << "its rim is in the ground";
  }
}

TEST(Tufts, StandOnTheGroundInViewAndOffTheTrail) {
  const auto [planting, terrain, pose, clip_from_world] = SeenForest();
  const GroundMap map = make_ground_map(planting, {0, 1, 0}, 2);
  std::vector<Tuft> tufts(kMaxTufts);
  tufts.resize(gather_tufts(terrain, map, clip_from_world, pose.position, tufts));
  EXPECT_GT(tufts.size(), 100u);
  for (const Tuft& tuft : tufts) {
    EXPECT_NEAR(tuft.root.y, height_at(terrain, tuft.root.x, tuft.root.z), 0.02f);
    EXPECT_GT(distance_from(planting.trail, {tuft.root.x, tuft.root.z}), 0.3f);
    EXPECT_GT((clip_from_world * glm::vec4(tuft.root, 1)).w, -0.2f);
  }
}

}  // namespace forest::forest_world_test
