#version 460
#extension GL_GOOGLE_include_directive : require

// Leaf quads of one instance: four vertices for each node id below 2m - 1, those not in cut(m) collapsed outside the clip volume.
// reads     view, instances, plants, cuts; pages, cards and materials by address. gl_InstanceIndex is the instance slot
// writes    position and the lit colour
// dispatch  indirect, from cull.comp's commands; recorded by coppice::gpu::record_draw

// COPPICE_LISTS is defined for clusters of the compute rasteriser's lists whose leaves are large: four vertices for each leaf of the
// cluster, from leaf_expand.comp's commands. gl_InstanceIndex names slot and list.

#include "bindings.glsl"
#include "shading.glsl"
#include "debug_view.glsl"
#include "leaf_shading.glsl"
#include "raster_items.glsl"

layout(push_constant, scalar) uniform Push { DrawPush push; };

layout(location = 0) out vec3 out_light;
layout(location = 4) out vec3 out_back_light;
layout(location = 1) out float out_transmittance;
layout(location = 2) out vec2 out_uv;
layout(location = 3) flat out float out_alpha_cutoff;

struct Quad {
  uint corners[6];
  uint card;
  uint leaf_count;  // of the cut that it is of
};

#ifdef COPPICE_LISTS

uint instance_slot() { return slot_of(gl_InstanceIndex); }
RasterList drawn_list() { return RasterListArray(push.vertices).at[list_of(gl_InstanceIndex)]; }
RasterLeaf drawn_leaf() { return RasterLeafArray(drawn_list().leaves).at[gl_VertexIndex >> 2]; }

bool fetch_quad(Plant plant, out Quad quad) {
  RasterLeaf leaf = drawn_leaf();
  quad = Quad(leaf.corners, leaf.card, drawn_list().leaf_count);
  return true;
}

CrownSample light_of(Plant plant, Crown crown, vec3 middle) { return unpack_crown(drawn_leaf().crown); }

#else

uint instance_slot() { return gl_InstanceIndex; }

// No branch: some drivers load for both sides of one, so that every address computed here has to be readable.
Node fetch_node(Plant plant, uint id) {
  uint index = max(id, 1) - 1;
  uvec2 page = AddressArray(plant.pages).at[index / kPageNodes];
  Node node = NodeArray(page).at[index % kPageNodes];
  if (id == 0) node = plant.root;
  return node;
}

// False: not in the cut.
bool fetch_quad(Plant plant, out Quad quad) {
  uint id = uint(gl_VertexIndex) >> 2;
  Node node = fetch_node(plant, min(id, 2 * plant.resident_leaf_count - 2));
  quad = Quad(node.corners, node.card & 0xffffu, min(coppice_whole_leaf_count(cuts[instance_slot()]), plant.resident_leaf_count));
  return coppice_node_alive(id, node.split, quad.leaf_count);
}

CrownSample light_of(Plant plant, Crown crown, vec3 middle) { return crown_light_at(plant, crown, middle); }

#endif

void main() {
  uint slot = instance_slot();
  uint corner = uint(gl_VertexIndex) & 3;
  Plant plant = plants[push.plant];
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  out_light = out_back_light = vec3(0.0);
  out_transmittance = 1.0;
  out_uv = vec2(0.0);
  out_alpha_cutoff = 0.0;
  Quad quad;
  if (!fetch_quad(plant, quad)) return;

  Instance instance = instances[slot];
  Card card = CardArray(plant.cards).at[quad.card];
  Material material = MaterialArray(plant.materials).at[card.material];
  if (material.texture != push.texture) return;
  vec3 corners[4];
  for (uint i = 0; i < 4; ++i) corners[i] = plant.box_min + plant.box_step * quantised(quad.corners, i);
  vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  float loss = outline_loss(corners, instance);
  // A quad of the same covered area, whatever the cutoff lets through: of the soft texels of a small mip level soon all.
  float let_through = mix(material.coverage, 1.0, min(1.5 * loss, 1.0));
  float scale = sqrt(material.coverage / let_through);
  vec3 object = middle + (corners[corner] - middle) * scale;
  vec3 world = world_from_object(instance, object);
  gl_Position = view.clip_from_world * vec4(world, 1.0);

  Crown crown = crown_of(plant);
  vec3 face = cross(corners[2] - corners[0], corners[3] - corners[1]);
  vec3 albedo = material.base_color.rgb * instance.tint * variation(crown, plant, uvec3(quantised(quad.corners, 0)));
  float size_m = max(distance(corners[0], corners[2]), distance(corners[1], corners[3]));
  float bulk = leaf_bulk(plant, crown, size_m, float(quad.leaf_count));
  LeafPlace leaf = LeafPlace(middle, object, face, material.crown_normals, bulk);
  out_light = albedo * leaf_light(plant, crown, light_of(plant, crown, middle), instance, leaf);
  out_transmittance = transmittance(world);
  out_uv = card.uv[corner];
  out_alpha_cutoff = material.alpha_cutoff * (1.0 - loss);
  if (view.debug_view != 0) {
    out_light = view.debug_view == kDebugPath ? kHardwareLeaves : debug_color(slot);
    out_transmittance = 1.0;
  }
  out_back_light = out_light;
}
