#pragma once

// What an engine may pass to coppice.h. Each function returns the first thing that is wrong as "field[index] is ...", for the
// log, or an empty string. What needs a device or the state of a context is checked where those are.

#include <cstdint>
#include <span>
#include <string>

#include "coppice/coppice.h"
#include "handle.h"
#include "vectors.h"

namespace coppice {

std::string desc_problem(const coppice_context_desc& desc);

/// What views of a context may be.
struct ViewLimits {
  std::uint32_t max_width_px = 0, max_height_px = 0;
};

std::string view_desc_problem(const coppice_view_desc& desc);

/// But for its view.
std::string camera_problem(const coppice_camera& camera, const ViewLimits& limits);

std::string wind_problem(const coppice_wind& wind);
std::string place_problem(std::span<const double, 3> place);
std::string sun_problem(const coppice_sun_desc& desc, const ViewLimits& limits);

/// origin: coppice_set_origin's
std::string placement_problem(const coppice_placement& placement, const dvec3& origin);
std::string scene_placement_problem(const coppice_scene_placement& placement, const dvec3& origin);
std::string origin_problem(std::span<const double, 3> origin);
/// low, high: [3], may be null
std::string box_problem(const double* low, const double* high);
std::string ray_problem(const coppice_ray& ray);

/// Whether it can be a handle of the kind in the context with this tag; not whether what it named is still there.
std::string handle_problem(std::uint64_t handle, HandleKind kind, std::uint32_t context_tag);

}  // namespace coppice
