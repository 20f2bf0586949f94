#version 460
// Reads nothing. Three vertices: a triangle over the whole view at the depth of a cleared pixel. Drawn by OcclusionAreas
// (bake/lod/areas/occlusion_areas.cpp) to count the background.
void main() {
  gl_Position = vec4(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0, 1.0, 1.0);
}
