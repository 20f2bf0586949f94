#include "uploads.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "block_texture.h"
#include "check.h"

namespace coppice::gpu {
namespace {

constexpr std::uint64_t kRingBytes = 8ull << 20;

VkImageMemoryBarrier2 layout_change(const Device& device, VkImage image, VkImageLayout from, VkImageLayout to) {
  const bool filling = to == VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
  return {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
          .srcStageMask = stages_of_queue(device, filling ? VK_PIPELINE_STAGE_2_NONE : VK_PIPELINE_STAGE_2_COPY_BIT),
          .srcAccessMask = filling ? VK_ACCESS_2_NONE : VK_ACCESS_2_TRANSFER_WRITE_BIT,
          .dstStageMask = stages_of_queue(device, filling ? VK_PIPELINE_STAGE_2_COPY_BIT
                                                          : VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT |
                                                                VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT),
          .dstAccessMask = filling ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
          .oldLayout = from,
          .newLayout = to,
          .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
          .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
          .image = image,
          .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0, 1}};
}

/// Rows of texels, or of blocks, in one mip level.
struct TexelRun {
  std::uint32_t mip = 0, width_px = 0;  ///< of the level
  std::uint32_t first_px = 0, height_px = 0;
  std::uint64_t at = 0;  ///< place in the texture's bytes, all levels in a row
  std::uint64_t row_bytes = 0, row_count = 0;
};

/// Calls take(run) for what lies in a range of a texture's bytes, level by level, until it returns false. The range begins and ends with
/// rows.
template <class Take>
void for_each_run(const Texture& texture, std::uint64_t first, std::uint64_t end, const Take& take) {
  std::uint64_t level_at = 0;
  for (std::uint32_t mip = 0; mip < texture.mip_count && level_at < end; ++mip) {
    const std::uint32_t width = std::max(texture.width >> mip, 1u), height = std::max(texture.height >> mip, 1u);
    const std::uint64_t level_bytes = texture_level_bytes(texture.format, width, height);
    const std::uint64_t row_bytes = texture_level_bytes(texture.format, width, 1);
    const auto row_px = static_cast<std::uint32_t>(height * row_bytes > level_bytes ? 4 : 1);
    const std::uint64_t from = std::max(first, level_at), to = std::min(end, level_at + level_bytes);
    if (from < to) {
      const auto first_row = static_cast<std::uint32_t>((from - level_at) / row_bytes);
      const auto row_count = static_cast<std::uint32_t>((to - from) / row_bytes);
      const std::uint32_t first_px = first_row * row_px;
      if (!take(TexelRun{mip, width, first_px, std::min(row_count * row_px, height - first_px), from, row_bytes, row_count})) return;
    }
    level_at += level_bytes;
  }
}

}  // namespace

Result<void> Uploads::create() {
  COPPICE_CHECK(moves_.make_room(allocator_, kMaxMoves));
  return move_into(ring_, create_buffer(device_, {"coppice staging", kRingBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::host}));
}

void Uploads::begin_frame(std::uint64_t frame_number, std::uint64_t completed_number) {
  frame_ = frame_number;
  while (!marks_.empty() && marks_.front().frame <= completed_number) {
    tail_ = marks_.front().head;
    marks_.pop_front();
  }
  if (marks_.empty()) head_ = tail_ = 0;
}

// Slices do not wrap: free space is a run up to the ring's end and one from its start.
std::uint64_t Uploads::room_bytes() const {
  const std::uint64_t capacity = ring_.size_bytes;
  const std::uint64_t free = capacity - (head_ - tail_);
  const std::uint64_t to_end = std::min(free, capacity - head_ % capacity);
  return std::max(to_end, free - to_end);
}

Result<Uploads::Slice> Uploads::stage(std::uint64_t bytes) {
  const std::uint64_t capacity = ring_.size_bytes;
  const std::uint64_t rounded = (bytes + 15) / 16 * 16;
  std::uint64_t start = head_;
  if (start % capacity + rounded > capacity) start += capacity - start % capacity;
  Slice slice;
  if (start + rounded - tail_ <= capacity) {
    head_ = start + rounded;
    if (marks_.empty() || marks_.back().frame != frame_) marks_.push_back({frame_, head_});
    marks_.back().head = head_;
    slice = {ring_.buffer, start % capacity, ring_.mapped + start % capacity};
  } else {
    COPPICE_TRY(buffer, create_buffer(device_, {"coppice staging", bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryKind::host}));
    slice = {buffer.buffer, 0, buffer.mapped};
    deletion_.defer(buffer);
  }
  return slice;
}

Result<std::uint8_t*> Uploads::copy(std::uint64_t bytes, const Buffer& to, std::uint64_t offset) {
  COPPICE_TRY(slice, stage(bytes));
  COPPICE_CHECK(copies_.append(allocator_, {slice.buffer, to.buffer, {slice.offset, offset, bytes}}));
  return slice.data;
}

Result<void> Uploads::copy(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset) {
  COPPICE_TRY(data, copy(bytes.size(), to, offset));
  std::memcpy(data, bytes.data(), bytes.size());
  return {};
}

Result<void> Uploads::patch(std::span<const std::uint8_t> bytes, const Buffer& to, std::uint64_t offset) {
  COPPICE_TRY(slice, stage(bytes.size()));
  std::memcpy(slice.data, bytes.data(), bytes.size());
  return patches_.append(allocator_, {slice.buffer, to.buffer, {slice.offset, offset, bytes.size()}});
}

Result<std::uint64_t> Uploads::fill(const Texture& texture, std::span<const std::uint8_t> texels, std::uint64_t at,
                                    std::uint64_t max_bytes) {
  const std::uint64_t first = at;
  for_each_run(texture, at, texels.size(), [&](const TexelRun& run) {
    const std::uint64_t rows = std::min((first + max_bytes - std::min(at, first + max_bytes)) / run.row_bytes, run.row_count);
    at += std::max<std::uint64_t>(rows, at == first ? 1 : 0) * run.row_bytes;
    return rows == run.row_count;
  });
  COPPICE_TRY(slice, stage(at - first));
  std::memcpy(slice.data, texels.data() + first, at - first);
  COPPICE_CHECK(fills_.append(allocator_, {slice.buffer, slice.offset, texture, first, at, at == texels.size()}));
  return at;
}

void Uploads::move(const Buffer& from, const Buffer& to) {
  moves_.push_back({from.buffer, to.buffer, {0, 0, std::min(from.size_bytes, to.size_bytes)}});
}

void Uploads::undo(const Mark& mark) {
  copies_.count = mark.copies;
  patches_.count = mark.patches;
  fills_.count = mark.fills;
}

void Uploads::record(VkCommandBuffer cmd) {
  bool first = true;
  for (BoundedList<Copy>* copies : {&moves_, &copies_, &patches_}) {
    if (copies->empty()) continue;
    if (!std::exchange(first, false))
      memory_barrier(device_, cmd, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT,
                     VK_ACCESS_2_TRANSFER_WRITE_BIT);
    record_copies(cmd, copies->span());
    copies->clear();
  }
  for (const Fill& fill : fills_.span()) record_fill(cmd, fill);
  fills_.clear();
}

// Groups copies between the same two buffers.
void Uploads::record_copies(VkCommandBuffer cmd, std::span<Copy> copies) {
  std::stable_sort(copies.begin(), copies.end(),
                   [](const Copy& a, const Copy& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  std::array<VkBufferCopy, 64> regions;
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < copies.size(); ++i) {
    regions[count++] = copies[i].region;
    const bool more = i + 1 < copies.size() && copies[i + 1].from == copies[i].from && copies[i + 1].to == copies[i].to;
    if (more && count < regions.size()) continue;
    device_.vk.vkCmdCopyBuffer(cmd, copies[i].from, copies[i].to, std::exchange(count, 0), regions.data());
  }
}

void Uploads::record_fill(VkCommandBuffer cmd, const Fill& fill) {
  const Texture& texture = fill.texture;
  const auto change_layout = [&](VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier2 barrier = layout_change(device_, texture.image, from, to);
    const VkDependencyInfo info{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
    device_.vk.vkCmdPipelineBarrier2(cmd, &info);
  };
  if (fill.first_texel == 0) change_layout(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  for_each_run(texture, fill.first_texel, fill.end_texel, [&](const TexelRun& run) {
    const VkBufferImageCopy region{.bufferOffset = fill.offset + run.at - fill.first_texel,
                                   .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, run.mip, 0, 1},
                                   .imageOffset = {0, static_cast<std::int32_t>(run.first_px), 0},
                                   .imageExtent = {run.width_px, run.height_px, 1}};
    device_.vk.vkCmdCopyBufferToImage(cmd, fill.from, texture.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
    return true;
  });
  if (fill.last) change_layout(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
}

void update_buffer(const Device& device, VkCommandBuffer cmd, const Buffer& buffer, std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kMaxUpdateBytes = 65536;
  for (std::size_t at = 0; at < bytes.size(); at += kMaxUpdateBytes)
    device.vk.vkCmdUpdateBuffer(cmd, buffer.buffer, at, std::min(kMaxUpdateBytes, bytes.size() - at), bytes.data() + at);
}

}  // namespace coppice::gpu
