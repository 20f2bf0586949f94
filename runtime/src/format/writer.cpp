#include "writer.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "layout.h"
#include "reader.h"

namespace coppice {

namespace {

using Buffer = std::vector<std::uint8_t>;

template <class T>
void append(Buffer& buffer, std::span<const T> values) {
  if (values.empty()) return;
  const std::size_t at = buffer.size();
  buffer.resize(at + values.size_bytes());
  std::memcpy(buffer.data() + at, values.data(), values.size_bytes());
}

template <class T>
void overwrite(Buffer& buffer, std::size_t at, const T& value) {
  std::memcpy(buffer.data() + at, &value, sizeof(T));
}

coppice_file_plant with_counts(const FileContents& contents) {
  const auto count = [](const auto& values) { return static_cast<std::uint32_t>(values.size()); };
  coppice_file_plant plant = contents.plant;
  plant.page_count = count(contents.pages);
  plant.material_count = count(contents.materials);
  plant.card_count = count(contents.cards);
  plant.texture_count = count(contents.textures);
  plant.wood_lod_count = count(contents.wood);
  plant.error_level_count = count(contents.error_leaf_counts);
  plant.error_size_count = count(contents.error_sizes_px);
  plant.leaf_mesh_count = static_cast<std::uint16_t>(contents.leaf_meshes.size());
  return plant;
}

/// Makes a TEXTURE chunk with only the largest level of at most side_px, or the smallest level there is; returns nothing if the chunk is
/// not valid.
Buffer small_texture(const Buffer& chunk, std::uint32_t side_px) {
  const auto layout = read_texture(chunk);
  if (!layout) return {};
  const auto fits = [&](const MipLevel& level) { return std::max(level.width, level.height) <= side_px; };
  const auto found = std::ranges::find_if(layout->levels(), fits);
  const MipLevel& level = found != layout->levels().end() ? *found : layout->levels().back();
  const coppice_file_texture header{level.width, level.height, 1, layout->format};
  Buffer small;
  append(small, std::span(&header, 1));
  append(small, std::span(chunk).subspan(static_cast<std::size_t>(level.offset), static_cast<std::size_t>(level.bytes)));
  return small;
}

}  // namespace

Buffer textures_chunk(const std::vector<Buffer>& textures, std::span<const coppice_file_material> materials) {
  Buffer headers;
  for (const Buffer& texture : textures) append(headers, std::span(texture).first(std::min(texture.size(), sizeof(coppice_file_texture))));
  for (std::uint32_t side_px = COPPICE_MAX_SMALL_TEXTURE_SIDE;; side_px /= 2) {
    Buffer chunk = headers;
    for (std::uint32_t i = 0; i < textures.size(); ++i)
      if (std::ranges::find(materials, i, material_texture) != materials.end())
        append(chunk, std::span<const std::uint8_t>(small_texture(textures[i], side_px)));
    if (chunk.size() <= COPPICE_SMALL_TEXTURES_BYTES || side_px == 1) return chunk;
  }
}

namespace {

void append_chunk(Buffer& file, const FileContents& contents, const coppice_file_plant& plant, ChunkKey key) {
  switch (key.kind) {
    case COPPICE_CHUNK_PLANT:
      return append(file, std::span(&plant, 1));
    case COPPICE_CHUNK_MATERIALS:
      return append(file, std::span(contents.materials));
    case COPPICE_CHUNK_CARDS:
      return append(file, std::span(contents.cards));
    case COPPICE_CHUNK_ERRORS:
      append(file, std::span(contents.error_leaf_counts));
      append(file, std::span(contents.error_sizes_px));
      append(file, std::span(contents.error_px));
      return append(file, std::span(contents.wood_error_px));
    case COPPICE_CHUNK_WIND:
      append(file, std::span(&contents.wind, 1));
      return append(file, std::span(contents.wind_nodes));
    case COPPICE_CHUNK_WOOD:
      return append(file, std::span(contents.wood[key.index]));
    case COPPICE_CHUNK_PAGE:
      return append(file, std::span(contents.pages[key.index]));
    case COPPICE_CHUNK_TEXTURE:
      return append(file, std::span(contents.textures[key.index]));
    case COPPICE_CHUNK_TEXTURES:
      return append(file, std::span<const std::uint8_t>(textures_chunk(contents.textures, contents.materials)));
    case COPPICE_CHUNK_LEAF_MESHES:
      append(file, std::span(contents.leaf_mesh_counts));
      return append(file, std::span(contents.leaf_mesh_error_px));
    case COPPICE_CHUNK_LEAF_MESH:
      return append(file, std::span(contents.leaf_meshes[key.index]));
    default:
      return;
  }
}

}  // namespace

Result<std::vector<std::uint8_t>> write_file(const FileContents& contents) {
  const coppice_file_plant plant = with_counts(contents);
  coppice_file_header header{};
  header.chunk_count = chunk_count(plant);
  Buffer file(sizeof header + header.chunk_count * sizeof(coppice_file_chunk));
  for (std::uint32_t i = 0; i < header.chunk_count; ++i) {
    const ChunkKey key = chunk_at(plant, i);
    const std::size_t at = file.size();
    append_chunk(file, contents, plant, key);
    const coppice_file_chunk entry{static_cast<std::uint32_t>(key.kind), key.index, at, file.size() - at,
                                   checksum(std::span(file).subspan(at))};
    overwrite(file, sizeof header + i * sizeof entry, entry);
    if (i + 1 == first_read_chunk_count(plant)) header.first_read_bytes = file.size();
  }
  std::memcpy(header.magic, COPPICE_FORMAT_MAGIC, sizeof header.magic);
  header.version = COPPICE_FORMAT_VERSION;
  header.file_bytes = file.size();
  header.table_checksum = checksum(std::span(file).subspan(sizeof header, header.chunk_count * sizeof(coppice_file_chunk)));
  overwrite(file, 0, header);
  header.header_checksum = checksum(std::span(file).first(offsetof(coppice_file_header, header_checksum)));
  overwrite(file, 0, header);

  if (auto front = read_front(file, file.size()); !front) {
    Error error = front.error();
    error.status = Status::invalid_argument;
    return error;
  }
  return file;
}

}  // namespace coppice
