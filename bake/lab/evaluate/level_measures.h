#pragma once

// One level against the source, in pictures and on the surface.

#include <cstdint>
#include <vector>

#include "evaluate.h"
#include "evaluation_render.h"
#include "image_measures.h"
#include "level.h"
#include "stored_level.h"
#include "surface_distance.h"

namespace coppice::bake {

/// What pictures and distances are compared with, and what it shows. Refers to what it is made of.
struct ReferenceSurface {
  const Mesh& mesh;
  const std::vector<Material>& materials;
  const std::vector<Image>& images;
  const StoredLevel* stored = nullptr;  ///< to be compared with it too
};

/// The source, and everything about it that each comparison needs.
struct Reference {
  std::uint32_t size_px = 0;
  bool suns_and_frames = false;
  Level level;
  std::vector<SurfaceLook> looks;
  std::vector<EvaluationCamera> cameras;
  std::vector<EvaluationImage> images;            ///< by camera
  std::vector<std::vector<float>> frame_means{};  ///< by camera; none unless suns_and_frames
  SurfaceSamples samples;
  TriangleTree tree;
  double area_m2 = 0.0, diagonal_m = 0.0;
};

/// Simplifiers are judged by where they put leaves, pictures of the plant as modelled by what they show.
SurfaceColour reference_colour(ReferenceKind reference);

/// errors  invalid_argument: no leaves, or none with an area; those of surface_looks
Result<Reference> make_reference(const ReferenceSurface& surface, const EvaluateOptions& options);

/// The pictures alone, of one frame under one sun.
ImageSums measure_pictures(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference);

/// All but what LevelMeasures says of the method. sums  what measure_pictures says of the level
LevelMeasures measure_level(const Level& level, const std::vector<SurfaceLook>& looks, const Reference& reference, const ImageSums& sums);

}  // namespace coppice::bake
