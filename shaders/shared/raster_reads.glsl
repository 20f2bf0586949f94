// Inputs of both the compute rasteriser's passes and the draw of its picture. After bindings.glsl and raster_shared.h.
// COPPICE_ACCESS: nothing, or readonly

layout(set = 1, binding = 0, scalar) COPPICE_ACCESS buffer PictureBuffer { uint picture[]; };
layout(set = 1, binding = 5, scalar) COPPICE_ACCESS buffer WorkBuffer { WorkItem work_items[]; };

// The same as texels: software drivers load a vector of texels at once, but buffers word by word.
layout(set = 1, binding = 8) uniform usamplerBuffer picture_words;
layout(set = 1, binding = 9) uniform usamplerBuffer work_texels;

layout(push_constant, scalar) uniform Push { RasterPush push; };

// A branch rather than ?:, which glslang translates wrongly for structs.
WorkItem work_at(uint place) {
  WorkItem work;
  if (kReadsTexels) {
    uvec4 texel = texelFetch(work_texels, int(place));
    work = WorkItem(texel.x, texel.y, texel.zw);
  } else {
    work = work_items[place];
  }
  return work;
}
uint picture_word(uint word) { return kReadsTexels ? texelFetch(picture_words, int(word)).x : picture[word]; }
