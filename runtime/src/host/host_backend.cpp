#include "host_backend.h"

#include <new>

namespace coppice {

Result<std::unique_ptr<Backend>> HostBackend::create(const BackendOptions& options) {
  constexpr std::uint32_t kMaxView_px = 1u << 20;
  std::unique_ptr<Backend> backend(new (std::nothrow) HostBackend({.max_instances = options.max_instances,
                                                                   .max_plants = options.max_plants,
                                                                   .max_view_width_px = kMaxView_px,
                                                                   .max_view_height_px = kMaxView_px,
                                                                   .sizes = {.host = true, .block_textures = options.block_textures}}));
  if (!backend) return Error{Status::out_of_memory, "host"};
  return backend;
}

}  // namespace coppice
