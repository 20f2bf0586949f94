#pragma once

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstdint>
#include <span>
#include <string>

namespace coppice::test {

/// What tinygltf reads of a .glb, without complaints; images stay as they are encoded.
inline tinygltf::Model parse_glb(std::span<const std::uint8_t> bytes) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(
      [](tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* encoded, int size, void*) {
        image->image.assign(encoded, encoded + size);
        return true;
      },
      nullptr);
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(loader.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), static_cast<unsigned>(bytes.size()))) << error;
  EXPECT_TRUE(warning.empty()) << warning;
  return model;
}

}  // namespace coppice::test
