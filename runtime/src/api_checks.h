#pragma once

// What an engine may pass to coppice.h. Each function returns the first thing that is wrong as "field[index] is ...", for the log, or an
// empty string. What needs a device or the state of a context is checked where those are.

#include <cstdint>
#include <string>

#include "coppice/coppice.h"
#include "handle.h"

namespace coppice {

std::string desc_problem(const coppice_context_desc& desc);

/// name  of the argument. struct_size of a struct that may be null; said: what coppice.h says of it
template <class T>
std::string struct_problem(const T* argument, const char* name) {
  if (argument == nullptr) return std::string(name) + " is null";
  if (argument->struct_size == sizeof(T)) return {};
  return std::string(name) + ".struct_size is " + std::to_string(argument->struct_size) + ", not " + std::to_string(sizeof(T)) +
         ": call its _init function, and compile against the header of the library";
}

/// What views of a context may be.
struct ViewLimits {
  std::uint32_t max_width_px = 0, max_height_px = 0;
};
std::string view_desc_problem(const coppice_view_desc& desc);

/// But for its view.
std::string camera_problem(const coppice_camera& camera, const ViewLimits& limits);

std::string light_problem(const coppice_light& light);

std::string sun_problem(const coppice_sun_desc& desc, const ViewLimits& limits);

std::string placement_problem(const coppice_placement& placement);

/// Whether it can be a handle of the kind in the context with this tag; not whether what it named is still there.
std::string handle_problem(std::uint64_t handle, HandleKind kind, std::uint32_t context_tag);

}  // namespace coppice
