// The hardware's draw of a cluster of leaf quads, as leaf.vert takes it. After clusters.glsl.

// leaves: the first so many
DrawCommand cluster_command(uint item, uint cluster, uint leaves) {
  return DrawCommand(6 * leaves, 1, 0, int(4 * kClusterLeaves * cluster), item);
}
