// The rasteriser's lists, and names of an instance and one of its plant's lists. After bindings.glsl.

#include "raster_shared.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RasterListArray { RasterList at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RasterLeafArray { RasterLeaf at[]; };

uint slot_of(uint item) { return item & (kRasterMaxInstances - 1u); }
uint list_of(uint item) { return item >> kSlotBits; }
