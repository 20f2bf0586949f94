#pragma once

// Measures one level against the source, on images and on the surface.

#include <cstdint>
#include <vector>

#include "evaluate.h"
#include "evaluation_render.h"
#include "image_measures.h"
#include "level_files.h"
#include "surface_distance.h"

namespace coppice::bake {

/// The surface that images and distances are compared with, and what it shows. Holds references.
struct ReferenceSurface {
  const Mesh& mesh;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const StoredLevel* stored = nullptr;  ///< to be compared too
};

/// The source, with everything that each comparison needs.
struct Reference {
  std::uint32_t size_px = 0;
  bool suns_and_frames = false;
  Level level;
  std::vector<SurfaceLook> looks;
  std::vector<EvaluationCamera> cameras;
  std::vector<EvaluationImage> images;            ///< [camera]
  std::vector<std::vector<float>> frame_means{};  ///< [camera] none unless suns_and_frames
  SurfaceSamples samples;
  TriangleTree tree;
  double area_m2 = 0.0, diagonal_m = 0.0;
};

/// Textured if images are compared with the plant as modelled; a mean colour if simplifiers are compared, by where they put leaves.
SurfaceColour reference_colour(ReferenceKind reference);

/// errors  invalid_argument: no leaves, or none with an area; those of surface_looks
Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options);

/// Compares images of one frame under one sun.
ImageSums measure_images(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference);

/// Computes all figures but those about the method. sums  from measure_images of this level
LevelMeasures measure_level(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference, const ImageSums& sums);

}  // namespace coppice::bake
