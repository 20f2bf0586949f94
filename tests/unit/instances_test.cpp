#include "instances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "fake_hooks.h"
#include "handle.h"

namespace coppice::gpu::instances_test {

constexpr std::uint32_t kPlants = 4;

InstanceTable make_table(std::uint32_t max_instances) {
  static test::FakeAllocator allocator;
  InstanceTable table(allocator.hook(), max_instances);
  EXPECT_TRUE(table.reserve_plants(kPlants));
  const float center[3] = {0, 1, 0};
  for (std::uint32_t plant = 0; plant < kPlants; ++plant) table.set_plant_sphere(plant, center, 1.0f);
  return table;
}

coppice_placement placed_at(float x) {
  coppice_placement placement = default_placement();
  placement.position[0] = x;
  placement.scale = 1.0f;
  placement.rotation[3] = 1.0f;
  return placement;
}

std::vector<coppice_instance> add_row(InstanceTable& table, std::uint32_t plant, std::size_t count) {
  std::vector<coppice_placement> placements;
  for (std::size_t i = 0; i < count; ++i) placements.push_back(placed_at(static_cast<float>(i)));
  std::vector<coppice_instance> handles(count);
  EXPECT_TRUE(table.add(plant, placements, handles));
  return handles;
}

std::vector<PlacedInstance> tile_of(std::size_t count, std::uint32_t plants) {
  std::vector<PlacedInstance> instances;
  for (std::uint32_t i = 0; i < count; ++i) instances.push_back({placed_at(static_cast<float>(i)), i % plants});
  return instances;
}

using Ranges = std::vector<std::array<std::uint32_t, 2>>;

/// Every range to upload, in order.
Ranges take_all_dirty(InstanceTable& table) {
  Ranges ranges;
  for (SlotRange range = table.take_dirty(); range.count > 0; range = table.take_dirty()) ranges.push_back({range.first, range.count});
  return ranges;
}

TEST(Instances, ThoseOfAPlantWithoutASphereAreKeptFromTheGpu) {
  InstanceTable table = make_table(1000);
  table.remove_plant(2);  // and its sphere
  const auto handles = add_row(table, 2, 40);
  EXPECT_EQ(table.count(), 40u);
  EXPECT_EQ(table.plant_count(2), 40u);
  table.move(handles[3], placed_at(-7));
  table.remove(handles[4]);
  EXPECT_FALSE(table.is_live(handles[4]));
  for (const Instance& instance : table.slots()) EXPECT_EQ(plant_of(instance), kNoPlant);
  take_all_dirty(table);
  const float center[3] = {0, 2, 0};
  table.set_plant_sphere(2, center, 3.0f);
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 40}}));
  for (std::uint32_t slot = 0; slot < 40; ++slot) EXPECT_EQ(plant_of(table.slots()[slot]), slot == 4 ? kNoPlant : 2u) << slot;
  EXPECT_EQ(table.slots()[3].position.x, -7.0f);
  EXPECT_EQ(table.spheres()[3].center_m[1], 2.0f);
  EXPECT_EQ(table.spheres()[3].radius_m, 3.0f);
  EXPECT_EQ(table.count(), 39u);
  EXPECT_TRUE(table.is_live(handles[3]));
  table.remove_plant(2);
  EXPECT_EQ(table.count(), 0u);
}

TEST(Instances, WhatChangedIsUploadedOnce) {
  InstanceTable table = make_table(1000);
  EXPECT_EQ(take_all_dirty(table), Ranges{});
  const auto handles = add_row(table, 0, 300);
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 300}}));
  EXPECT_EQ(take_all_dirty(table), Ranges{});
  table.move(handles[70], placed_at(5));
  table.move(handles[290], placed_at(5));
  EXPECT_EQ(take_all_dirty(table), (Ranges{{64, 64}, {256, 44}}));
  EXPECT_EQ(take_all_dirty(table), Ranges{});
  table.move(handles[0], placed_at(6));
  table.move(handles[299], placed_at(6));
  table.mark_dirty(table.take_dirty());  // an upload that failed
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 64}, {256, 44}}));
}

TEST(Instances, WhatMovesOrTurnsOrGrowsHasAPlaceBefore) {
  InstanceTable table = make_table(100);
  const auto handles = add_row(table, 0, 5);
  table.forget_moves();
  coppice_placement moved = placed_at(-3), turned = placed_at(1), grown = placed_at(2), tinted = placed_at(3);
  turned.rotation[1] = std::exchange(turned.rotation[3], 0.0f);
  grown.scale = 2.0f;
  tinted.tint[0] = 0.5f;
  const std::array placements{moved, turned, grown, tinted};
  for (std::size_t i = 0; i < placements.size(); ++i) table.move(handles[i], placements[i]);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NE(table.slots()[i].before, 0u) << i;
  EXPECT_EQ(table.slots()[3].before, 0u) << "stands where it stood";
  EXPECT_EQ(table.slots()[4].before, 0u);
}

TEST(Instances, BoundsFollowWhatMovesAndWhatGoes) {
  InstanceTable table = make_table(100);
  const auto handles = add_row(table, 2, 40);
  table.update_bounds();
  ASSERT_EQ(table.blocks().bounds.size(), 2u);
  EXPECT_EQ(table.blocks().bounds[0].instance_count, kInstanceBlockSlots);
  EXPECT_EQ(table.blocks().bounds[1].instance_count, 8u);
  EXPECT_EQ(table.blocks().bounds[1].plant, 2u);
  EXPECT_DOUBLE_EQ(table.blocks().bounds[0].center_m[0], 15.5) << "half way between 0 and 31";
  table.move(handles[0], placed_at(-31));
  table.update_bounds();
  EXPECT_DOUBLE_EQ(table.blocks().bounds[0].center_m[0], 0.0);
  EXPECT_FLOAT_EQ(table.blocks().bounds[0].radius_m, 32.0f);
  for (std::size_t i = 32; i < 40; ++i) table.remove(handles[i]);
  table.update_bounds();
  EXPECT_LT(table.blocks().bounds[1].radius_m, 0.0f) << "empty";
}

TEST(Instances, MoreThanThereIsRoomForAreNotAdded) {
  InstanceTable table = make_table(70);
  add_row(table, 0, 60);
  const std::vector<coppice_placement> eleven(11, placed_at(0));
  EXPECT_EQ(table.add(1, eleven, {}).error().status, Status::out_of_memory);
  EXPECT_EQ(table.count(), 60u);
  EXPECT_EQ(table.plant_count(1), 0u);
  EXPECT_TRUE(table.add(1, std::span(eleven).first(10), {}));
}

TEST(Instances, AnEmptyTableHasNoMemory) {
  test::FakeAllocator allocator;
  InstanceTable table(allocator.hook(), 1u << 24);
  EXPECT_EQ(allocator.calls, 0u);
  EXPECT_EQ(table.bytes(), 0u);
  EXPECT_EQ(table.free_block_count(), (1u << 24) / 64);
  EXPECT_TRUE(table.slots().empty());
}

TEST(Instances, ATableGrowsByHalfAndKeepsWhatItHolds) {
  test::FakeAllocator allocator;
  {
    InstanceTable table(allocator.hook(), 100000);
    ASSERT_TRUE(table.reserve_plants(kPlants));
    const float center[3] = {0, 1, 0};
    table.set_plant_sphere(3, center, 2.0f);
    const auto first = add_row(table, 3, 1000);
    const InstanceTile tile = *table.add_tile(7, tile_of(70, 1));
    table.remove(first[7]);
    take_all_dirty(table);
    table.move(first[900], placed_at(-5));
    EXPECT_EQ(table.capacity(), 1536u);
    std::uint32_t growths = 0;
    for (std::uint32_t before = table.capacity(); table.count() < 100000 - 64 * 2; before = table.capacity()) {
      ASSERT_TRUE(table.add(3, std::vector<coppice_placement>(1, placed_at(0)), {}));
      if (before != table.capacity()) ++growths;
      EXPECT_EQ(table.bytes(), allocator.live_bytes);
    }
    EXPECT_LE(growths, 11u) << "1.5 to the eleventh is above 66";
    EXPECT_EQ(table.capacity(), 100000u);
    EXPECT_FALSE(table.is_live(first[7]));
    EXPECT_TRUE(table.is_live(first[8]));
    EXPECT_EQ(table.slots()[8].position.x, 8.0f);
    EXPECT_EQ(table.slots()[900].position.x, -5.0f);
    EXPECT_EQ(plant_of(table.slots()[900]), 3u);
    EXPECT_EQ(take_all_dirty(table)[0], (std::array<std::uint32_t, 2>{0, 64})) << "a slot that was given out again";
    table.remove_tile(tile);
    EXPECT_EQ(table.plant_count(0), 0u);
  }
  EXPECT_EQ(allocator.live_count, 0u);
}

TEST(Instances, AnEmptyEndIsGivenBackAndItsHandlesStayDead) {
  InstanceTable table = make_table(100000);
  const auto first = add_row(table, 0, 100), gone = add_row(table, 1, 5000);
  const InstanceTile tile = *table.add_tile(7, tile_of(70, 2));
  const auto last = add_row(table, 2, 300);
  table.forget_moves();
  table.move(first[3], placed_at(-7));
  for (const coppice_instance handle : gone) table.remove(handle);
  EXPECT_GT(table.min_capacity(), 5000u) << "the tile and the last ones are at the end";
  table.remove_tile(tile);
  for (const coppice_instance handle : last) table.remove(handle);
  const std::uint32_t capacity = table.min_capacity();
  EXPECT_EQ(capacity, 128u);
  EXPECT_LE(table.slots().size(), capacity);
  const std::uint64_t before = table.bytes();
  auto smaller = table.resized(capacity);
  ASSERT_TRUE(smaller);
  table.take(*std::move(smaller));
  EXPECT_EQ(table.capacity(), capacity);
  EXPECT_LT(table.bytes(), before / 4);
  EXPECT_EQ(table.count(), 100u);
  EXPECT_EQ(table.moved().size(), 1u);
  EXPECT_EQ(table.slots()[3].position.x, -7.0f);

  const auto again = add_row(table, 3, 5400);
  for (const coppice_instance handle : gone) EXPECT_FALSE(table.is_live(handle));
  for (const coppice_instance handle : last) EXPECT_FALSE(table.is_live(handle));
  for (const coppice_instance handle : first) EXPECT_TRUE(table.is_live(handle));
  EXPECT_EQ(table.plant_count(3), 5400u);

  for (const coppice_instance handle : first) table.remove(handle);
  for (const coppice_instance handle : again) table.remove(handle);
  EXPECT_EQ(table.min_capacity(), 0u);
  auto none = table.resized(0);
  ASSERT_TRUE(none);
  table.take(*std::move(none));
  table.update_bounds();
  EXPECT_TRUE(take_all_dirty(table).empty());
  EXPECT_TRUE(table.is_live(add_row(table, 0, 1)[0]));
}

TEST(Instances, WithoutMemoryATableStaysAsItWas) {
  test::FakeAllocator allocator;
  InstanceTable table(allocator.hook(), 100000);
  ASSERT_TRUE(table.reserve_plants(kPlants));
  for (const std::size_t count : {10u, 5000u}) {
    const std::uint32_t before = table.count();
    for (std::size_t n = 0; n < 8; ++n) {
      const std::size_t live_bytes = allocator.live_bytes;
      allocator.fail_at = allocator.calls + n;
      EXPECT_EQ(table.add(0, std::vector<coppice_placement>(count, placed_at(0)), {}).error().status, Status::out_of_memory) << n;
      EXPECT_EQ(allocator.live_bytes, live_bytes);
      EXPECT_EQ(table.count(), before);
    }
    add_row(table, 0, count);
  }
}

TEST(Instances, AHandleDiesWithItsInstance) {
  InstanceTable table = make_table(70);
  const auto handles = add_row(table, 0, 3);
  table.remove(handles[1]);
  EXPECT_FALSE(table.is_live(handles[1]));
  EXPECT_TRUE(table.is_live(handles[2]));
  const auto next = add_row(table, 1, 1);
  EXPECT_NE(next[0], handles[1]) << "the slot's next instance has another handle";
  EXPECT_FALSE(table.is_live(handles[1]));
  table.remove_plant(0);
  EXPECT_FALSE(table.is_live(handles[2]));
  EXPECT_TRUE(table.is_live(next[0]));
  EXPECT_EQ(table.count(), 1u);
}

TEST(Instances, ATileHasBlocksOfItsOwn) {
  InstanceTable table = make_table(64 * 6);
  const auto handles = add_row(table, 0, 10);
  const InstanceTile tile = *table.add_tile(7, tile_of(130, 2));
  EXPECT_EQ(tile.block_count, 3u);
  EXPECT_EQ(table.free_block_count(), 2u);
  EXPECT_EQ(table.count(), 140u);
  EXPECT_EQ(table.plant_count(1), 65u);
  const auto more = add_row(table, 3, 54);
  for (std::uint32_t slot = 64; slot < 64 + 130; ++slot) {
    EXPECT_NE(plant_of(table.slots()[slot]), 3u) << "one by one fills its own block";
    EXPECT_FALSE(table.is_live(pack_handle({HandleKind::instance, 0, 0, slot}))) << "no handle is an instance of a tile";
  }
  EXPECT_EQ(table.add_tile(7, tile_of(129, 1)).error().status, Status::out_of_memory);
  EXPECT_EQ(table.count(), 194u);
  table.remove_tile(tile);
  EXPECT_EQ(table.count(), 64u);
  EXPECT_EQ(table.plant_count(1), 0u);
  EXPECT_EQ(table.free_block_count(), 5u);
  for (const auto handle : handles) EXPECT_TRUE(table.is_live(handle));
}

TEST(Instances, BlocksThatEmptyServeTilesAndTheOtherWayRound) {
  InstanceTable table = make_table(64 * 2 + 5);
  for (int round = 0; round < 3; ++round) {
    const auto handles = add_row(table, 0, 133);
    EXPECT_EQ(table.free_block_count(), 0u);
    EXPECT_FALSE(table.add(0, std::vector<coppice_placement>(1, placed_at(0)), {})) << "full";
    for (const auto handle : handles) table.remove(handle);
    EXPECT_EQ(table.free_block_count(), 2u) << "the short block is no tile's";
    const InstanceTile first = *table.add_tile(7, tile_of(64, 1));
    const InstanceTile second = *table.add_tile(7, tile_of(1, 1));
    EXPECT_TRUE(table.add(1, std::vector<coppice_placement>(5, placed_at(0)), {}));
    EXPECT_FALSE(table.add(1, std::vector<coppice_placement>(1, placed_at(0)), {}));
    table.remove_plant(1);
    table.remove_plant(0);
    EXPECT_EQ(table.count(), 0u);
    EXPECT_EQ(table.free_block_count(), 0u) << "a tile keeps its blocks until it goes";
    table.remove_tile(first);
    table.remove_tile(second);
    EXPECT_EQ(table.free_block_count(), 2u);
  }
}

TEST(Instances, ATileGrowsUpWithoutFurtherUploads) {
  InstanceTable table = make_table(64 * 2);
  const InstanceTile tile = *table.add_tile(7, tile_of(3, 1));
  table.grow_tile(tile, 4);
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 3}}));
  table.forget_moves();
  take_all_dirty(table);
  for (const float share : {0.25f, 0.5f, 0.75f, 1.0f}) {
    table.begin_frame();
    EXPECT_EQ(table.grown_share_at(2), share);
    EXPECT_EQ(table.is_growing(), share < 1.0f);
    EXPECT_EQ(table.slots()[2].scale, 1.0f) << "its own";
    EXPECT_EQ(table.spheres()[2].radius_m, 1.0f);
    if (share == 1.0f) break;
    EXPECT_EQ(take_all_dirty(table), Ranges{}) << "the GPU counts frames itself";
  }
  EXPECT_EQ(table.slots()[2].before, 0u) << "it is over";
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 3}}));
  for (int i = 0; i < 70000; ++i) table.begin_frame();
  EXPECT_EQ(table.grown_share_at(2), 1.0f) << "not even when 16 bits of frames are over";
}

TEST(Instances, AMoveDoesNotEndGrowthAndANewPlantBegins) {
  InstanceTable table = make_table(1000);
  table.remove_plant(2);  // and its sphere
  const auto known = add_row(table, 0, 1), unknown = add_row(table, 2, 1);
  table.grow(known[0], 10);
  table.grow(unknown[0], 10);
  for (int i = 0; i < 5; ++i) {
    table.begin_frame();
    table.forget_moves();
  }
  table.move(known[0], placed_at(-7));
  EXPECT_EQ(table.grown_share_at(0), 0.5f);
  const float center[3] = {0, 1, 0};
  table.set_plant_sphere(2, center, 1.0f);
  table.begin_frame();
  EXPECT_EQ(table.grown_share_at(1), 0.1f) << "nobody has seen it before";
  for (int i = 0; i < 100; ++i) table.begin_frame();
  table.forget_moves();
  table.move(known[0], placed_at(-8));
  EXPECT_EQ(table.slots()[0].before, 1u) << "it has a place before again";
  EXPECT_EQ(table.moved()[0].before, 0u);
  table.grow(known[0], 10);
  table.remove(known[0]);
  const auto next = add_row(table, 0, 1);
  EXPECT_EQ(table.grown_share_at(0), 1.0f) << "growth goes with the instance";
}

TEST(Instances, MembersOfATileAreFoundByNumberAndReplacedWhereTheyStand) {
  InstanceTable table = make_table(64 * 8);
  const auto handles = add_row(table, 0, 70);
  std::vector<PlacedInstance> members = tile_of(150, 2);
  members[63].plant = members[64].plant = members[149].plant = kNoPlant;
  const InstanceTile other = *table.add_tile(5, tile_of(3, 1));
  const InstanceTile tile = *table.add_tile(9, members);
  EXPECT_EQ(table.count(), 70u + 3 + 147);
  for (std::uint32_t number = 0; number < 150; ++number) {
    const std::uint32_t slot = table.member_slot(tile, number);
    EXPECT_EQ(table.member_at(slot).tile, 9u);
    EXPECT_EQ(table.member_at(slot).number, number);
    EXPECT_EQ(table.placed_at(slot).plant, members[number].plant);
    EXPECT_EQ(table.handle_at(slot), 0u);
    if (members[number].plant == kNoPlant) continue;
    EXPECT_EQ(table.placed_at(slot).placement.position[0], members[number].placement.position[0]);
  }
  EXPECT_EQ(table.member_at(table.member_slot(other, 2)).tile, 5u);
  EXPECT_EQ(table.member_at(unpack_handle(handles[69]).index).tile, TileMember::kNoTile);

  // An empty one is filled, another emptied, a third becomes one of another plant.
  const std::uint32_t of_plant_0 = table.plant_count(0), of_plant_1 = table.plant_count(1);
  table.set_member(table.member_slot(tile, 64), members[62]);
  table.set_member(table.member_slot(tile, 2), {{}, kNoPlant});
  PlacedInstance moved = members[4];
  moved.plant = 1 - moved.plant;
  table.set_member(table.member_slot(tile, 4), moved);
  EXPECT_EQ(table.count(), 70u + 3 + 147);
  EXPECT_EQ(table.plant_count(0) + table.plant_count(1), of_plant_0 + of_plant_1);
  EXPECT_EQ(table.placed_at(table.member_slot(tile, 4)).plant, moved.plant);
  EXPECT_EQ(plant_of(table.slots()[table.member_slot(tile, 2)]), kNoPlant);
  table.remove_tile(tile);
  table.remove_tile(other);
  EXPECT_EQ(table.count(), 70u);
  EXPECT_EQ(table.plant_count(1), 0u);
}

TEST(Instances, SlotsOfATileThatAreNotUsedAreUploadedEmpty) {
  InstanceTable table = make_table(64 * 4);
  ASSERT_TRUE(table.add_tile(7, tile_of(10, 1)));
  ASSERT_TRUE(table.add_tile(7, tile_of(10, 1)));
  EXPECT_EQ(take_all_dirty(table), (Ranges{{0, 74}}));
  for (std::uint32_t slot = 10; slot < 64; ++slot) EXPECT_EQ(plant_of(table.slots()[slot]), kNoPlant);
}

/// The slots of instances with handles.
std::map<coppice_instance, std::uint32_t> slots_by_handle(const InstanceTable& table) {
  std::map<coppice_instance, std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < table.slots().size(); ++slot)
    if (table.spheres()[slot].plant != kNoPlant && table.handle_at(slot) != 0) slots[table.handle_at(slot)] = slot;
  return slots;
}

/// Sum of the radii of culling blocks, m.
double extent_m(InstanceTable& table) {
  table.update_bounds();
  double sum_m = 0;
  for (const InstanceBounds& bounds : table.blocks().bounds)
    sum_m += bounds.instance_count > 0 ? static_cast<double>(bounds.radius_m) : 0.0;
  return sum_m;
}

/// On a square with a side of 2 km. Positions are whole numbers, so tables hold them exactly.
std::vector<coppice_placement> in_random_order(std::size_t count) {
  std::mt19937 random(7);
  std::vector<coppice_placement> placements(count, placed_at(0));
  for (coppice_placement& placement : placements)
    for (const std::size_t axis : {std::size_t{0}, std::size_t{2}})
      placement.position[axis] = static_cast<double>(random() % 2000) - 1000.0;
  return placements;
}

void sort_all(InstanceTable& table) {
  for (int i = 0; i < 10000 && !table.is_sorted(); ++i) table.begin_frame();
  EXPECT_TRUE(table.is_sorted());
}

TEST(InstanceOrder, BecomesThatOfPlaces) {
  constexpr std::size_t kCount = 20000;
  InstanceTable table = make_table(1u << 17), twin = make_table(1u << 17);
  const std::vector<coppice_placement> placements = in_random_order(kCount);
  std::vector<coppice_instance> handles(kCount);
  ASSERT_TRUE(table.add(0, placements, handles));
  ASSERT_TRUE(twin.add(0, placements, {}));
  const double random_m = extent_m(table);
  std::vector<std::uint32_t> seeds;
  for (const Instance& instance : table.slots()) seeds.push_back(seed_of(instance));
  take_all_dirty(table);
  std::uint32_t frames = 0, most_slots = 0;
  for (; frames < 10000 && !table.is_sorted(); ++frames) {
    table.begin_frame();
    std::uint32_t slots = 0;
    for (const auto& [first, count] : take_all_dirty(table)) slots += count;
    most_slots = std::max(most_slots, slots);
  }
  EXPECT_GT(frames, 10u);
  EXPECT_LT(frames, 200u);
  EXPECT_LT(most_slots, 8192u) << "a frame has little to upload";
  EXPECT_LT(extent_m(table), 0.1 * random_m);
  const auto slots = slots_by_handle(table);
  for (std::size_t i = 0; i < kCount; ++i) {
    ASSERT_TRUE(table.is_live(handles[i]));
    const std::uint32_t slot = slots.at(handles[i]);
    EXPECT_EQ(table.placed_at(slot).placement.position[0], placements[i].position[0]);
    EXPECT_EQ(table.placed_at(slot).placement.position[2], placements[i].position[2]);
    EXPECT_EQ(seed_of(table.slots()[slot]), seeds[i]) << "its random choices";
  }
  sort_all(twin);
  EXPECT_TRUE(std::ranges::equal(slots_by_handle(twin), slots)) << "the same each time";
  for (int i = 0; i < 100; ++i) table.begin_frame();
  EXPECT_EQ(take_all_dirty(table), Ranges{}) << "what is sorted stays";
  table.move(handles[5], placements[5]);
  EXPECT_TRUE(table.is_sorted()) << "it has not moved";
  table.move(handles[5], placed_at(900));
  EXPECT_FALSE(table.is_sorted());
  sort_all(table);
  EXPECT_EQ(slots_by_handle(table).size(), kCount);
}

TEST(InstanceOrder, SurvivesChangesAtAnyTime) {
  InstanceTable table = make_table(1u << 14);
  std::mt19937 random(3);
  const std::vector<coppice_placement> places = in_random_order(8000);
  std::map<coppice_instance, double> expected;
  std::vector<InstanceTile> tiles;
  const auto any = [&] { return std::next(expected.begin(), static_cast<std::ptrdiff_t>(random() % expected.size())); };
  std::size_t next = 0;
  for (int frame = 0; frame < 400; ++frame) {
    for (int i = 0; i < 20 && next < places.size(); ++i, ++next) {
      coppice_instance handle = 0;
      ASSERT_TRUE(table.add(0, std::vector(1, places[next]), {&handle, 1}));
      expected[handle] = places[next].position[0];
    }
    for (int i = 0; i < 8; ++i) {
      const auto moved = any();
      moved->second = static_cast<double>(random() % 2000);
      table.move(moved->first, placed_at(static_cast<float>(moved->second)));
      const auto gone = any();
      table.remove(gone->first);
      EXPECT_FALSE(table.is_live(gone->first));
      expected.erase(gone);
    }
    if (frame % 9 == 0) tiles.push_back(*table.add_tile(static_cast<std::uint32_t>(frame), tile_of(100, 2)));
    if (frame % 20 == 0 && frame > 0) {
      table.remove_tile(tiles.front());
      tiles.erase(tiles.begin());
    }
    table.begin_frame();
    table.forget_moves();
  }
  const auto check = [&] {
    const auto slots = slots_by_handle(table);
    ASSERT_EQ(slots.size(), expected.size());
    for (const auto& [handle, x] : expected) {
      ASSERT_TRUE(table.is_live(handle));
      EXPECT_EQ(table.placed_at(slots.at(handle)).placement.position[0], x);
    }
    for (const InstanceTile& tile : tiles)
      for (std::uint32_t number = 0; number < 100; ++number)
        EXPECT_EQ(table.placed_at(table.member_slot(tile, number)).placement.position[0], static_cast<double>(number));
  };
  check();
  const double before_m = extent_m(table);
  sort_all(table);
  check();
  EXPECT_LE(extent_m(table), before_m * 1.05);
  for (const auto& [handle, x] : expected) table.remove(handle);
  for (const InstanceTile& tile : tiles) table.remove_tile(tile);
  EXPECT_EQ(table.count(), 0u);
  sort_all(table);
}

}  // namespace coppice::gpu::instances_test
