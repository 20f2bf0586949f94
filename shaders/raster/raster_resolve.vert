#version 460
// One triangle over the whole picture; recorded by coppice::gpu::LeafRaster::record_resolve.

void main() { gl_Position = vec4(gl_VertexIndex == 1 ? 3.0 : -1.0, gl_VertexIndex == 2 ? 3.0 : -1.0, 0.5, 1.0); }
