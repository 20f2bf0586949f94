// Draw commands of the hardware, and how many of them each plant has. After clusters.glsl.

layout(set = 0, binding = 6, scalar) writeonly buffer LeafCommandBuffer { DrawCommand leaf_commands[]; };
layout(set = 0, binding = 7, scalar) buffer DrawCountBuffer { uint draw_counts[]; };
layout(set = 0, binding = 8, scalar) buffer WoodCommandBuffer { DrawCommand wood_commands[]; };

// The first of so many new places that draw_counts[counted] counts: all of them below the capacity, or none, which the capacity says.
uint take_commands(uint counted, uint count, uint capacity) {
  for (uint taken = draw_counts[counted]; taken + count <= capacity;) {
    uint seen = atomicCompSwap(draw_counts[counted], taken, taken + count);
    if (seen == taken) return taken;
    taken = seen;
  }
  return capacity;
}

// The draw of a cluster of leaf quads, as leaf.vert takes it. leaves: the first so many
DrawCommand cluster_command(uint item, uint cluster, uint leaves) {
  return DrawCommand(6 * leaves, 1, 0, int(4 * kClusterLeaves * cluster), item);
}
