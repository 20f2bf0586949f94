#pragma once

// Computes a view's demand for a plant, and the value of each chunk: pixels of error that it removes from the picture per byte of memory.
// The same function values requests and eviction candidates, so an exchange that helped is never undone.

#include <cstdint>

#include "demand.h"

namespace coppice {

/// The properties of a plant that values depend on.
struct ValuedPlant {
  lod::CoppiceTable table{};
  std::uint32_t leaf_count = 1;
  std::uint64_t page_bytes = 1;       ///< memory a resident page takes
  std::uint64_t leaf_mesh_bytes = 0;  ///< all leaf meshes together, and the textures that only they show; 0: there are none
};

/// The finest detail of a plant that a view demands.
struct DemandedDetail {
  std::uint32_t page_count = 0;         ///< pages [0, page_count)
  std::uint32_t finest_wood = 0;        ///< wood LoDs [finest_wood, table.wood_lod_count)
  std::uint64_t max_texture_bytes = 0;  ///< textures that take no more; 0: none
  bool leaf_meshes = false;             ///< and the textures that only they show
};

/// True if a view demands the plant's leaf meshes.
bool demands_leaf_meshes(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view);

/// The finest wood LoD that a view demands.
std::uint32_t demanded_wood(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view);

/// True if a plant without its textures is wrong by more than the view's threshold.
bool needs_textures(const PlantDemand& demand, const LodView& view);

/// for_others  another view demands the leaf meshes, so they are resident for this view too
DemandedDetail demanded_detail(const ValuedPlant& plant, const PlantDemand& demand, const LodView& view, bool for_others = false);

/// Returns the maximum of both demands.
DemandedDetail merged(const DemandedDetail& a, const DemandedDetail& b);

/// Value, px/byte, of foliage page `page` if those before it are resident. 0: not in demand; a page in demand has a value above 0 even if
/// the table is flat. If later pages remove more error than this one, its value is the best average over a run of pages that starts with
/// it, because they need it.
float page_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view,
                 std::uint32_t page);

/// Value of wood LoD `lod` if the next coarser one is resident. bytes: its memory
float wood_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view,
                 std::uint32_t lod, std::uint64_t bytes);

/// Value of a texture of `bytes`: without it every leaf of every instance is wrong.
float texture_value(const DemandedDetail& demanded, const PlantDemand& demand, std::uint64_t bytes);

/// Value of each chunk of leaf meshes, and of a texture that only they show. Nothing is drawn before all are resident, so all have the same
/// value: their gain together divided by their bytes together.
float leaf_mesh_value(const ValuedPlant& plant, const DemandedDetail& demanded, const PlantDemand& demand, const LodView& view);

}  // namespace coppice
