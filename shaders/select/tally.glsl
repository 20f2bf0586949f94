// Collects the counts of invocations and adds them to the counters, a group at a time. leaf_blocks.comp counts whole blocks that are hidden
// by itself. After bindings.glsl.

#include "counters.glsl"

struct Tally {
  uint visible, occluded;  // instances
  uint leaves;             // those that leaf_expand.comp does not count
};

shared Tally group;

// All invocations of a group must call it.
void add_to_counters(Tally tally) {
  if (gl_LocalInvocationIndex == 0) group = Tally(0, 0, 0);
  barrier();
  atomicAdd(group.visible, tally.visible);
  atomicAdd(group.occluded, tally.occluded);
  atomicAdd(group.leaves, tally.leaves);
  barrier();
  if (gl_LocalInvocationIndex != 0) return;
  if (group.visible > 0) atomicAdd(counters.visible_instances, group.visible);
  if (group.occluded > 0) atomicAdd(counters.occluded_instances, group.occluded);
  COPPICE_COUNT(leaves, group.leaves)
}
