// Draw commands of the hardware, and how many of them each plant has. After clusters.glsl.

layout(set = 0, binding = 6, scalar) writeonly buffer LeafCommandBuffer { DrawCommand leaf_commands[]; };
layout(set = 0, binding = 7, scalar) buffer DrawCountBuffer { uint draw_counts[]; };
layout(set = 0, binding = 8, scalar) buffer WoodCommandBuffer { DrawCommand wood_commands[]; };

// The first of so many new places that draw_counts[counted] counts. Those from the capacity on do not exist. Whoever gets some below it and
// some beyond fills the former. Once the capacity is reached the count never falls below it again: what others take meanwhile stays beyond.
uint take_commands(uint counted, uint count, uint capacity) {
  uint first = atomicAdd(draw_counts[counted], count);
  if (first + count > capacity) atomicMin(draw_counts[counted], capacity);
  return first;
}

// The draw of a cluster of leaf quads, as leaf.vert takes it. leaves: the first so many
DrawCommand cluster_command(uint item, uint cluster, uint leaves) {
  return DrawCommand(6 * leaves, 1, 0, int(4 * kClusterLeaves * cluster), item);
}
