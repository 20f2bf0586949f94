#pragma once

// What a view wants of a plant, and what each chunk is worth: pixels of error it removes from the picture per byte of memory it takes.
// The same function values requests and victims, so an exchange that helped can never be undone by its reverse.

#include <cstdint>

#include "demand.h"

namespace coppice {

/// A plant's figures that values depend on.
struct ValuedPlant {
  lod::CoppiceTable table{};
  std::uint32_t leaf_count = 1;
  std::uint64_t page_bytes = 1;       ///< memory a resident page takes
  std::uint64_t leaf_mesh_bytes = 0;  ///< of all leaf meshes together and the textures that only they show; 0: none to be had
};

/// The finest detail a view asks of a plant.
struct PlantWants {
  std::uint32_t page_count = 0;   ///< pages [0, page_count)
  std::uint32_t finest_wood = 0;  ///< wood LoDs [finest_wood, table.wood_lod_count)
  bool textures = false;
  bool leaf_meshes = false;  ///< and the textures that only they show
};

/// Whether a view asks for the plant's leaf meshes.
bool wants_leaf_meshes(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view);

/// for_others  another view asks for the leaf meshes: then they are there for this one too
PlantWants plant_wants(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view, bool for_others = false);

/// What both ask for.
PlantWants merged(const PlantWants& a, const PlantWants& b);

/// Value, px/byte, of foliage page `page`, given those before it. 0: not wanted; a wanted page is worth more than 0 even where the table is
/// flat. Where later pages buy more than this one, it is worth the best average over a run that it begins, since they need it.
float page_value(const ValuedPlant& plant, const PlantWants& wants, const PlantDemand& demand, const LodView& view, std::uint32_t page);

/// Value of wood LoD `lod`, given the next coarser one. bytes: memory it takes.
float wood_value(const ValuedPlant& plant, const PlantWants& wants, const PlantDemand& demand, const LodView& view, std::uint32_t lod,
                 std::uint64_t bytes);

/// Value of a texture of `bytes`: without one every leaf of every instance is wrong.
float texture_value(const PlantWants& wants, const PlantDemand& demand, std::uint64_t bytes);

/// Value of each chunk of leaf meshes, and of a texture that only they show. Nothing is drawn before all are there, so all are worth the
/// same: what they gain together, by their bytes together.
float leaf_mesh_value(const ValuedPlant& plant, const PlantWants& wants, const PlantDemand& demand, const LodView& view);

}  // namespace coppice
