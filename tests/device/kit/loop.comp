#version 460
// Lanes with different counts, a compare-and-swap in a branch, ballots in the loop: what leaf_expand.comp no longer does.
#extension GL_KHR_shader_subgroup_ballot : require
layout(local_size_x_id = 1) in;
layout(set = 0, binding = 0) buffer Out { uint at[]; };  // 0 appended, 1 taken, 2 groups, 3 work group size, 4 sum of trips; from 16 on places
layout(push_constant) uniform Push { uint words[20]; } push;
uint take(uint most) {
  for (uint taken = at[1]; taken + 1 <= most;) {
    uint seen = atomicCompSwap(at[1], taken, taken + 1);
    if (seen == taken) return taken;
    taken = seen;
  }
  return most;
}
void append(bool some, uint value) {
  uvec4 which = subgroupBallot(some);
  uint count = subgroupBallotBitCount(which), first = 0;
  if (count == 0) return;
  if (subgroupElect()) first = atomicAdd(at[0], count);
  uint index = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(which);
  if (some && index < push.words[18]) at[16 + index] = value;
}
void main() {
  if (gl_LocalInvocationIndex == 0) { atomicMax(at[2], gl_NumWorkGroups.x); atomicMax(at[3], gl_WorkGroupSize.x); }
  for (uint item = gl_WorkGroupID.x; item < push.words[0]; item += gl_NumWorkGroups.x)
    for (uint i = gl_LocalInvocationIndex; i < 5 + 37 * (item % 7); i += gl_WorkGroupSize.x) {
      bool large = (i * 2654435769u >> 29) == 0;
      if (large) large = take(push.words[1]) != push.words[1];
      append(!large && (i & 1) == 0, item);
      append(!large && (i & 1) == 1, item);
      if (large) atomicAdd(at[4], 1);
    }
}
