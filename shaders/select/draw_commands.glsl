// Draw commands of the hardware, and their number for each plant. After clusters.glsl.

layout(set = 0, binding = 6, scalar) writeonly buffer LeafCommandBuffer { DrawCommand leaf_commands[]; };
layout(set = 0, binding = 7, scalar) buffer DrawCountBuffer { uint draw_counts[]; };
layout(set = 0, binding = 8, scalar) buffer WoodCommandBuffer { DrawCommand wood_commands[]; };

// Returns the first of `count` new places that draw_counts[counted] counts. Places from the capacity on do not exist. A caller whose places
// cross the capacity fills those below it. Once the count has reached the capacity it never falls below it again: places that others take
// meanwhile stay beyond.
uint take_commands(uint counted, uint count, uint capacity) {
  uint first = atomicAdd(draw_counts[counted], count);
  if (first + count > capacity) atomicMin(draw_counts[counted], capacity);
  return first;
}

// The draw of a cluster of leaf quads, for leaf.vert. leaves: the number of leaves from the first on
DrawCommand cluster_command(uint item, uint cluster, uint leaves) {
  return DrawCommand(6 * leaves, 1, 0, int(4 * kClusterLeaves * cluster), item);
}
