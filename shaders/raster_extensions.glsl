// Before anything else in a shader that includes write_pixel.glsl.
#ifdef COPPICE_INT64
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
