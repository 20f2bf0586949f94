#include "host_backend.h"

#include <limits>
#include <new>

namespace coppice {

Result<std::unique_ptr<Backend>> HostBackend::create(const BackendOptions& options) {
  constexpr std::uint32_t kMostView_px = 1u << 20;
  std::unique_ptr<Backend> backend(new (std::nothrow) HostBackend({.max_instances = options.max_instances,
                                                                   .max_plants = options.max_plants,
                                                                   .max_view_width_px = kMostView_px,
                                                                   .max_view_height_px = kMostView_px,
                                                                   .sizes = {}}));
  if (!backend) return Error{Status::out_of_memory, "host"};
  return backend;
}

Result<void> HostBackend::add_plant(std::uint32_t, const PlantFile&, const gpu::PlantAppearance&, std::span<const std::uint32_t>) {
  return {};
}

void HostBackend::remove_plant(std::uint32_t) {}

void HostBackend::hide_chunk(ChunkId) {}

}  // namespace coppice
