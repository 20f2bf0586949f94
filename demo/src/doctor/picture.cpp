#include "picture.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "failure.h"
#include "hazel.h"

namespace forest {
namespace {

struct Chunk {
  std::vector<std::uint8_t> bytes;
  std::uint32_t vertices = 0, indices = 0, width = 0, height = 0;
};

/// What the library has handed out of the plant.
struct Hazel {
  coppice_file_info info;
  std::vector<coppice_material> materials;
  std::vector<Chunk> chunks[COPPICE_STREAMED_ALL];
};

void open_file(const coppice_context* context, std::uint32_t file, Hazel& hazel) {
  coppice_file_info_init(&hazel.info);
  check(context, coppice_file_get_info(context, file, &hazel.info), "coppice_file_get_info");
  for (std::uint32_t i = 0; i < hazel.info.material_count; ++i) {
    coppice_material material;
    coppice_material_init(&material);
    check(context, coppice_file_get_material(context, file, i, &material), "coppice_file_get_material");
    hazel.materials.push_back(material);
  }
}

void take_changes(coppice_context* context, Hazel& hazel) {
  coppice_change change;
  coppice_change_init(&change);
  for (;;) {
    check(context, coppice_next_change(context, &change), "coppice_next_change");
    if (change.kind == COPPICE_CHANGE_NONE) return;
    if (change.kind == COPPICE_CHANGE_PLANT_OPENED) open_file(context, change.file, hazel);
    if (change.kind != COPPICE_CHANGE_CHUNK_ADDED) continue;
    std::vector<Chunk>& chunks = hazel.chunks[change.chunk];
    if (chunks.size() <= change.index) chunks.resize(change.index + 1);
    const auto* bytes = static_cast<const std::uint8_t*>(change.bytes);
    chunks[change.index] = {{bytes, bytes + change.byte_count}, change.vertex_count, change.index_count, change.width, change.height};
    check(context, coppice_confirm(context, &change, COPPICE_OUTCOME_TAKEN), "coppice_confirm");
  }
}

/// As coppice_mesh_vertex, and leaves are written so too.
struct Vertex {
  float position[3], normal[3], uv[2];
  std::uint32_t material;
  float color[4];  ///< linear; alpha: share of its pixels that are drawn
};

struct Corner {
  glm::vec2 px;
  float w_inverse;
  glm::vec2 uv_over_w;
};

struct Surface {
  const coppice_material* material;
  const Chunk* texture;  ///< null: none
  glm::vec3 color;
  float share;
};

/// RGBA8 texels of one level.
struct Level {
  const std::uint8_t* texels = nullptr;
  std::uint32_t width = 1, height = 1;
};

Level level_for(const Chunk& texture, float texels_per_px) {
  Level level{texture.bytes.data(), texture.width, texture.height};
  while (texels_per_px > 1.5f && (level.width > 1 || level.height > 1)) {
    level.texels += std::size_t{4} * level.width * level.height;
    level.width = std::max(level.width / 2, 1u);
    level.height = std::max(level.height / 2, 1u);
    texels_per_px *= 0.5f;
  }
  return level;
}

float linear_of(std::uint8_t srgb) {
  const float value = static_cast<float>(srgb) / 255.0f;
  return value <= 0.04045f ? value / 12.92f : std::pow((value + 0.055f) / 1.055f, 2.4f);
}

float cross(glm::vec2 a, glm::vec2 b) {
  return a.x * b.y - a.y * b.x;
}

/// One of sixteen, 0 to 15: a leaf with gaps is drawn where it is below its share.
std::uint32_t pattern(int x, int y) {
  constexpr std::uint8_t kPlaces[16] = {0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
  return kPlaces[(y & 3) * 4 + (x & 3)];
}

/// False: a hole.
bool sample(const Surface& surface, const Level& level, glm::vec2 uv, glm::vec3& color) {
  color = surface.color;
  if (!level.texels) return true;
  const auto place = [](float t, std::uint32_t size) {
    return std::min(static_cast<std::uint32_t>((t - std::floor(t)) * static_cast<float>(size)), size - 1);
  };
  const std::uint8_t* texel = level.texels + 4 * (std::size_t{place(uv.y, level.height)} * level.width + place(uv.x, level.width));
  if (static_cast<float>(texel[3]) / 255.0f < surface.material->alpha_cutoff) return false;
  color *= glm::vec3(linear_of(texel[0]), linear_of(texel[1]), linear_of(texel[2]));
  return true;
}

void draw_triangle(Picture& picture, const Corner (&c)[3], const Surface& surface) {
  constexpr float kLast_px = kPictureSide_px - 1;
  const float area = cross(c[1].px - c[0].px, c[2].px - c[0].px);
  if (std::abs(area) < 1e-6f) return;
  const glm::vec2 low = glm::max(glm::floor(glm::min(c[0].px, glm::min(c[1].px, c[2].px))), glm::vec2(0));
  const glm::vec2 high = glm::min(glm::max(c[0].px, glm::max(c[1].px, c[2].px)), glm::vec2(kLast_px));
  Level level;
  if (surface.texture) {
    const auto uv = [&](int i) { return c[i].uv_over_w / c[i].w_inverse; };
    const auto texels = static_cast<float>(surface.texture->width) * static_cast<float>(surface.texture->height);
    level = level_for(*surface.texture, std::sqrt(std::abs(cross(uv(1) - uv(0), uv(2) - uv(0)) / area) * texels));
  }
  for (int y = static_cast<int>(low.y); y <= static_cast<int>(high.y); ++y)
    for (int x = static_cast<int>(low.x); x <= static_cast<int>(high.x); ++x) {
      const glm::vec2 at = glm::vec2(x, y) + 0.5f;
      const glm::vec3 share = glm::vec3(cross(c[2].px - c[1].px, at - c[1].px), cross(c[0].px - c[2].px, at - c[2].px),
                                        cross(c[1].px - c[0].px, at - c[0].px)) /
                              area;
      if (share.x < 0 || share.y < 0 || share.z < 0 || static_cast<float>(pattern(x, y)) >= 16.0f * surface.share) continue;
      const float w_inverse = share.x * c[0].w_inverse + share.y * c[1].w_inverse + share.z * c[2].w_inverse;
      const std::size_t place = static_cast<std::size_t>(y) * kPictureSide_px + static_cast<std::size_t>(x);
      glm::vec3 color;
      if (kNear_m * w_inverse <= picture.depth[place]) continue;
      const glm::vec2 uv = (share.x * c[0].uv_over_w + share.y * c[1].uv_over_w + share.z * c[2].uv_over_w) / w_inverse;
      if (!sample(surface, level, uv, color)) continue;
      picture.depth[place] = kNear_m * w_inverse;
      picture.color[place] = color;
    }
}

struct Drawing {
  Picture& picture;
  const Hazel& hazel;
  const coppice_draw& draw;
  glm::mat4 clip_from_world;
};

/// False: it is behind the eye, and its triangle is left out.
bool project(const Drawing& drawing, const float (&position)[3], const float (&uv)[2], Corner& corner) {
  const coppice_draw& draw = drawing.draw;
  const glm::quat rotation(draw.rotation[3], draw.rotation[0], draw.rotation[1], draw.rotation[2]);
  const glm::vec3 origin(draw.position[0], draw.position[1], draw.position[2]);
  const glm::vec4 clip = drawing.clip_from_world * glm::vec4(origin + rotation * (draw.scale * glm::make_vec3(position)), 1);
  if (clip.w < kNear_m) return false;
  corner = {(0.5f + 0.5f * glm::vec2(clip.x, clip.y) / clip.w) * float{kPictureSide_px}, 1 / clip.w, glm::vec2(uv[0], uv[1]) / clip.w};
  return true;
}

/// color_of  colour and share of a triangle by its first vertex
template <class V, class ColorOf>
void draw_triangles(const Drawing& drawing, const V* vertices, const std::uint32_t* indices, std::uint32_t count, const ColorOf& color_of) {
  for (std::uint32_t i = 0; i + 2 < count; i += 3) {
    Corner corners[3];
    bool in_front = true;
    for (int k = 0; k < 3; ++k) {
      const V& vertex = vertices[indices[i + static_cast<std::uint32_t>(k)]];
      in_front = in_front && project(drawing, vertex.position, vertex.uv, corners[k]);
    }
    if (!in_front) continue;
    const V& first = vertices[indices[i]];
    const coppice_material& material = drawing.hazel.materials[first.material];
    const std::vector<Chunk>& textures = drawing.hazel.chunks[COPPICE_STREAMED_TEXTURES];
    const bool has_texture = material.texture < textures.size() && !textures[material.texture].bytes.empty();
    const glm::vec4 color = color_of(first, material);
    draw_triangle(drawing.picture, corners, {&material, has_texture ? &textures[material.texture] : nullptr, glm::vec3(color), color.w});
  }
}

void draw_mesh(const Drawing& drawing, const Chunk& mesh, const glm::vec3& tint) {
  const auto* vertices = reinterpret_cast<const coppice_mesh_vertex*>(mesh.bytes.data());
  const auto* indices = reinterpret_cast<const std::uint32_t*>(vertices + mesh.vertices);
  draw_triangles(drawing, vertices, indices, mesh.indices, [&](const coppice_mesh_vertex&, const coppice_material& material) {
    return glm::vec4(glm::make_vec3(material.base_color) * tint, 1);
  });
}

void draw_leaves(const coppice_context* context, const Drawing& drawing) {
  coppice_leaf_layout layout;
  coppice_leaf_layout_init(&layout);
  layout.vertex_bytes = sizeof(Vertex);
  layout.position = offsetof(Vertex, position);
  layout.uv = offsetof(Vertex, uv);
  layout.color = offsetof(Vertex, color);
  layout.material = offsetof(Vertex, material);
  coppice_leaf_output output;
  coppice_leaf_output_init(&output);
  const auto write = [&] {
    check(context, coppice_write_leaves(context, drawing.draw.file, drawing.draw.leaf_count, &layout, &output), "coppice_write_leaves");
  };
  write();  // how many?
  std::vector<Vertex> vertices(output.vertex_count);
  std::vector<std::uint32_t> indices(output.index_count);
  output.vertices = vertices.data();
  output.indices = indices.data();
  output.vertex_capacity = output.vertex_count;
  output.index_capacity = output.index_count;
  write();
  const glm::vec3 tint = glm::make_vec3(drawing.draw.tint);
  draw_triangles(drawing, vertices.data(), indices.data(), output.index_count, [&](const Vertex& vertex, const coppice_material&) {
    return glm::vec4(glm::make_vec3(vertex.color) * tint, vertex.color[3]);
  });
}

void draw_plant(const coppice_context* context, const Drawing& drawing) {
  const coppice_draw& draw = drawing.draw;
  const auto& chunks = drawing.hazel.chunks;
  if (draw.wood_lod != COPPICE_NONE) draw_mesh(drawing, chunks[COPPICE_STREAMED_WOOD].at(draw.wood_lod), glm::vec3(1));
  if (draw.leaf_meshes)
    for (const Chunk& mesh : chunks[COPPICE_STREAMED_LEAF_MESHES]) draw_mesh(drawing, mesh, glm::make_vec3(draw.tint));
  else
    draw_leaves(context, drawing);
}

void load(coppice_context* context, const coppice_camera& camera, Hazel& hazel) {
  std::uint32_t settled = COPPICE_FALSE;
  for (std::uint64_t number = 1; !settled; ++number) {
    coppice_frame frame;
    coppice_frame_init(&frame);
    frame.frame_number = number;
    frame.completed_number = number - 1;
    frame.cameras = &camera;
    frame.camera_count = 1;
    check(context, coppice_frame_begin(context, &frame), "coppice_frame_begin");
    take_changes(context, hazel);
    check(context, coppice_is_settled(context, camera.view, &settled), "coppice_is_settled");
    if (!settled) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

Bytes hazel() {
  return {kHazel, sizeof kHazel};
}

void check(const coppice_context* context, coppice_status status, const char* call) {
  if (status == COPPICE_OK) return;
  const std::string reason = coppice_last_error(context);
  throw Failure(reason.empty() ? std::string(call) + ": " + coppice_status_text(status) : reason);
}

Reference draw_on_processor(const Stand& stand) {
  coppice_context_desc desc;
  coppice_context_desc_init(&desc);
  coppice_context* made = nullptr;
  check(nullptr, coppice_context_create(&desc, &made), "coppice_context_create");
  const Context context(made, coppice_context_destroy);
  coppice_view_desc view_desc;
  coppice_view_desc_init(&view_desc);
  coppice_camera camera = stand.camera;
  check(made, coppice_view_create(made, &view_desc, &camera.view), "coppice_view_create");
  coppice_plant plant = 0;
  check(made, coppice_plant_open_memory(made, kHazel, sizeof kHazel, "hazel", &plant), "coppice_plant_open_memory");
  check(made,
        coppice_instances_add(made, plant, stand.plants.data(), sizeof(coppice_placement), static_cast<std::uint32_t>(stand.plants.size()),
                              nullptr),
        "coppice_instances_add");
  Hazel hazel;
  load(made, camera, hazel);

  Reference reference;
  std::vector<coppice_draw> draws(stand.plants.size());
  check(made,
        coppice_get_draws(made, camera.view, draws.data(), static_cast<std::uint32_t>(draws.size()), sizeof(coppice_draw),
                          &reference.instances),
        "coppice_get_draws");
  draws.resize(reference.instances);
  const glm::mat4 clip_from_world = glm::mat4(glm::make_mat4(camera.clip_from_view)) * glm::mat4(glm::make_mat4(camera.view_from_world));
  for (const coppice_draw& draw : draws) {
    reference.leaves += draw.leaf_meshes ? static_cast<double>(hazel.info.leaf_count) : std::ceil(double{draw.leaf_count} * 0.999999);
    draw_plant(made, {reference.picture, hazel, draw, clip_from_world});
  }
  return reference;
}

Difference difference_of(const Picture& picture, const Picture& reference) {
  constexpr std::uint32_t kBlock_px = 8;
  constexpr float kPixels = kBlock_px * kBlock_px;
  Difference sum;
  float blocks = 0, both = 0;
  for (std::uint32_t top = 0; top < kPictureSide_px; top += kBlock_px)
    for (std::uint32_t left = 0; left < kPictureSide_px; left += kBlock_px) {
      float coverage = 0, any = 0;
      glm::vec3 color(0);
      for (std::uint32_t y = top; y < top + kBlock_px; ++y)
        for (std::uint32_t x = left; x < left + kBlock_px; ++x) {
          const std::size_t at = std::size_t{y} * kPictureSide_px + x;
          const float a = picture.depth[at], b = reference.depth[at];
          coverage += static_cast<float>(a > 0) - static_cast<float>(b > 0);
          any += static_cast<float>(a > 0 || b > 0);
          color += picture.color[at] - reference.color[at];
          if (a <= 0 || b <= 0) continue;
          sum.depth += std::abs(a - b) / std::max(a, b);
          ++both;
        }
      if (any == 0) continue;
      ++blocks;
      sum.coverage += coverage * coverage / (kPixels * kPixels);
      sum.color += glm::dot(color, color) / (3 * kPixels * kPixels);
    }
  // Nothing in common is as wrong as can be.
  if (both == 0) return {1, 1, 1};
  return {std::sqrt(sum.coverage / blocks), sum.depth / both, std::sqrt(sum.color / blocks)};
}

}  // namespace forest
