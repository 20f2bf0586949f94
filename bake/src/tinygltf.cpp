// The one translation unit that compiles tinygltf and stb's image writer; everyone else includes their headers only. tinygltf is built
// without an image reader: image_decode.h is ours. Compiled here rather than taken from the packaged shared library, so that what we are
// built with is what we were tested with.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
