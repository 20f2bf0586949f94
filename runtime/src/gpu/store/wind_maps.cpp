#include "wind_maps.h"

#include <algorithm>
#include <utility>

#include "check.h"
#include "coppice_shared.h"
#include "ledger.h"

namespace coppice::gpu {
namespace {

/// The value for WindNow::map: never 0.
std::uint64_t address_of(std::uint32_t place) {
  return std::uint64_t{1} << 32 | place * kMaxMapPlaces;
}

}  // namespace

void WindMaps::release_copy() {
  if (device_.memory.ledger != nullptr) device_.memory.ledger->release(copy_.bytes());
  copy_.reset();
}

Result<void> WindMaps::begin_frame(FrameWind& wind) {
  // The frame before may have ended without an upload.
  release_copy();
  wind.before.map_address = std::exchange(is_uploaded_, false) ? address_of(place_) : 0;
  wind.now.map_address = 0;
  if (wind.now.wind.map == nullptr) return {};
  if (auto copied = copy_map(wind.now.wind); !copied) {
    release_copy();
    return copied;
  }
  place_ = (place_ + 1) % kWindMaps;
  wind.now.map_address = address_of(place_);
  return {};
}

Result<void> WindMaps::copy_map(const coppice_wind& wind) {
  const std::size_t count = std::size_t{2} * wind.map_width * wind.map_height;
  COPPICE_ASSERT(count <= 2 * kMaxMapPlaces);
  if (!fits_buffer(device_, count * sizeof(float))) return Error{Status::out_of_memory, "the memory budget has no room for the map"};
  COPPICE_CHECK(allocate_into(copy_, allocator_, count));
  if (device_.memory.ledger != nullptr) device_.memory.ledger->reserve(copy_.bytes());
  std::copy_n(wind.map, count, copy_.begin());
  return {};
}

Result<void> WindMaps::upload(Uploads& uploads, const Buffer& maps) {
  if (copy_.empty()) return {};
  COPPICE_CHECK(uploads.copy(bytes_of(std::as_const(copy_).span()), maps, std::uint64_t{place_} * kMaxMapPlaces * sizeof(vec2)));
  release_copy();
  is_uploaded_ = true;
  return {};
}

}  // namespace coppice::gpu
