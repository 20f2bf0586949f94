#include "wind_maps.h"

#include <algorithm>
#include <utility>

#include "ledger.h"

namespace coppice::gpu {

WindMaps::~WindMaps() {
  give_copy();
  destroy_buffer(device_, now_);
  destroy_buffer(device_, before_);
}

void WindMaps::give_copy() {
  if (device_.memory.ledger != nullptr) device_.memory.ledger->give(copy_.bytes());
  copy_.reset();
}

void WindMaps::begin_frame(FrameWind& wind) {
  // A frame may end without an upload.
  give_copy();
  if (before_.buffer != VK_NULL_HANDLE) garbage_.retire(before_);
  if (std::exchange(is_uploaded_, false))
    before_ = std::exchange(now_, {});
  else if (now_.buffer != VK_NULL_HANDLE)
    garbage_.retire(now_);
  if (wind.now.wind.map != nullptr)
    if (auto taken = take(wind.now.wind); !taken) {
      give_copy();
      go_on_without(device_, taken.error(), "plants move without the wind's map");
    }
  wind.now.map_address = now_.address;
  wind.before.map_address = before_.address;
}

Result<void> WindMaps::take(const coppice_wind& wind) {
  const std::size_t count = std::size_t{2} * wind.map_width * wind.map_height;
  if (!fits_buffer(device_, 2 * count * sizeof(float))) return Error{Status::out_of_memory, "the memory budget has no room for the map"};
  COPPICE_CHECK(allocate_into(copy_, allocator_, count));
  if (device_.memory.ledger != nullptr) device_.memory.ledger->take(copy_.bytes());
  std::copy_n(wind.map, count, copy_.begin());
  constexpr VkBufferUsageFlags kUsage =
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  return move_into(now_, create_buffer(device_, {"coppice wind map", copy_.bytes(), kUsage}));
}

Result<void> WindMaps::upload(Uploads& uploads) {
  if (copy_.empty()) return {};
  COPPICE_CHECK(uploads.copy(bytes_of(std::as_const(copy_).span()), now_, 0));
  give_copy();
  is_uploaded_ = true;
  return {};
}

}  // namespace coppice::gpu
