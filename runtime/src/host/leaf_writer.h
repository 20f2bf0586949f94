#pragma once

// Writes leaf quads as vertices of a host.

#include <cstdint>
#include <span>
#include <string>

#include "coppice/coppice.h"
#include "crown_light.h"
#include "reader.h"
#include "tree.h"

namespace coppice {

/// Says what is wrong with a layout; empty if nothing is.
std::string layout_problem(const coppice_leaf_layout& layout);

/// Writes the leaves of a cut one after the other.
class LeafWriter {
 public:
  /// layout: checked. output: large enough. All arguments outlive it
  LeafWriter(const PlantFile& file, const gpu::LeafBox& box, const coppice_leaf_layout& layout, const coppice_leaf_output& output)
      : file_(file), box_(box), layout_(layout), output_(output) {}
  void write(const PageNode& node);
  [[nodiscard]] std::uint32_t leaf_count() const { return leaf_count_; }

 private:
  void write_color(unsigned char* vertex, const PageNode& node, const coppice_file_material& material) const;
  void write_indices();

  const PlantFile& file_;
  const gpu::LeafBox box_;
  const coppice_leaf_layout& layout_;
  const coppice_leaf_output& output_;
  std::uint32_t leaf_count_ = 0;
};

}  // namespace coppice
