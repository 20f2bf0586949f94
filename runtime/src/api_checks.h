#pragma once

// Checks the arguments of coppice.h. Each function returns its first problem as "field[index] is ...", for the log, or an empty string.
// Checks that need a device or the state of a context are made elsewhere.

#include <cstdint>
#include <span>
#include <string>

#include "coppice/coppice.h"
#include "handle.h"
#include "vectors.h"

namespace coppice {

std::string desc_problem(const coppice_context_desc& desc);

/// Limits of a context's views.
struct ViewLimits {
  std::uint32_t max_width_px = 0, max_height_px = 0;
};

std::string view_desc_problem(const coppice_view_desc& desc);

/// Checks everything but the view.
std::string camera_problem(const coppice_camera& camera, const ViewLimits& limits);

std::string wind_problem(const coppice_wind& wind);
std::string place_problem(std::span<const double, 3> place);
std::string sun_problem(const coppice_sun_desc& desc, const ViewLimits& limits);

/// origin: the one of coppice_set_origin
std::string placement_problem(const coppice_placement& placement, const dvec3& origin);
std::string scene_placement_problem(const coppice_scene_placement& placement, const dvec3& origin);
std::string origin_problem(std::span<const double, 3> origin);
/// low, high: [3], may be null
std::string box_problem(const double* low, const double* high);
std::string ray_problem(const coppice_ray& ray);

/// Checks that the bits can be a handle of this kind in the context with this tag. Does not check that the named object still exists.
std::string handle_problem(std::uint64_t handle, HandleKind kind, std::uint32_t context_tag);

}  // namespace coppice
