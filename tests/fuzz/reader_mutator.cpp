// libFuzzer's mutator for .coppice files: fields of the header, a chunk's entry, PLANT, a material, a card, the tables, or bytes of a
// chunk, singly and in pairs. reader_fuzz makes the checksums right.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <utility>
#include <vector>

#include "coppice/format.h"
#include "field_mutator.h"

namespace {

using coppice::test::add_fields;
using coppice::test::FieldType;
using coppice::test::File;
using coppice::test::Record;
using coppice::test::Records;

constexpr std::size_t kMaxEntries = 64;

Record header_record() {
  Record record;
  add_fields(record, offsetof(coppice_file_header, version), FieldType::u32, 2);
  add_fields(record, offsetof(coppice_file_header, file_bytes), FieldType::u64, 2);
  return record;
}

Record plant_record(std::size_t at) {
  Record record;
  add_fields(record, at, FieldType::u32, 8);
  add_fields(record, at + offsetof(coppice_file_plant, leaf_box_min), FieldType::f32, 10);
  add_fields(record, at + offsetof(coppice_file_plant, root_quad), FieldType::u16, 12);
  add_fields(record, at + offsetof(coppice_file_plant, root_card), FieldType::u8, 2);
  add_fields(record, at + offsetof(coppice_file_plant, root_normals), FieldType::u16);
  add_fields(record, at + offsetof(coppice_file_plant, wood_vertex_counts), FieldType::u32, 1 + 2 * COPPICE_MAX_WOOD_LODS);
  add_fields(record, at + offsetof(coppice_file_plant, leaf_mesh_count), FieldType::u16, 2);
  add_fields(record, at + offsetof(coppice_file_plant, name), FieldType::u8, 64);
  return record;
}

Record material_record(std::size_t at) {
  Record record;
  add_fields(record, at, FieldType::f32, 6);
  add_fields(record, at + offsetof(coppice_file_material, texture_or_none), FieldType::u16, 2);
  add_fields(record, at + offsetof(coppice_file_material, flags), FieldType::u32);
  return record;
}

/// The records of a chunk.
std::vector<Record> chunk_records(const coppice_file_chunk& chunk) {
  std::vector<Record> records;
  const auto at = static_cast<std::size_t>(chunk.offset), bytes = static_cast<std::size_t>(chunk.bytes);
  const auto elements = [&](std::size_t element_bytes) { return std::min(bytes / element_bytes, kMaxEntries); };
  if (chunk.kind == COPPICE_CHUNK_PLANT) {
    records.push_back(plant_record(at));
  } else if (chunk.kind == COPPICE_CHUNK_MATERIALS) {
    for (std::size_t i = 0; i < elements(sizeof(coppice_file_material)); ++i)
      records.push_back(material_record(at + i * sizeof(coppice_file_material)));
  } else if (chunk.kind == COPPICE_CHUNK_CARDS) {
    for (std::size_t i = 0; i < elements(sizeof(coppice_file_card)); ++i) {
      add_fields(records.emplace_back(), at + i * sizeof(coppice_file_card), FieldType::u32);
      add_fields(records.back(), at + i * sizeof(coppice_file_card) + 4, FieldType::f32, 8);
      add_fields(records.back(), at + i * sizeof(coppice_file_card) + 36, FieldType::u32, 3);
    }
  } else if (chunk.kind == COPPICE_CHUNK_ERRORS || chunk.kind == COPPICE_CHUNK_LEAF_MESHES) {
    add_fields(records.emplace_back(), at, FieldType::f32, elements(4));
    add_fields(records.emplace_back(), at, FieldType::u32, elements(4));
  } else if (chunk.kind == COPPICE_CHUNK_WIND) {
    add_fields(records.emplace_back(), at, FieldType::f32, std::min<std::size_t>(bytes / 4, 13));
    add_fields(records.back(), at + offsetof(coppice_file_wind, node_side), FieldType::u32);
    for (std::size_t i = sizeof(coppice_file_wind); i + 4 <= bytes; i += 4) add_fields(records.emplace_back(), at + i, FieldType::u8, 4);
  } else if (chunk.kind == COPPICE_CHUNK_TEXTURES) {
    for (std::size_t i = 0; i < elements(sizeof(coppice_file_texture)); ++i)
      add_fields(records.emplace_back(), at + i * sizeof(coppice_file_texture), FieldType::u32, 4);
  } else if (chunk.kind == COPPICE_CHUNK_TEXTURE) {
    add_fields(records.emplace_back(), at, FieldType::u32, 4);
  } else {
    // Headers and tables come first.
    add_fields(records.emplace_back(), at, FieldType::u8, std::min<std::size_t>(bytes, 64));
    add_fields(records.emplace_back(), at, FieldType::u8, bytes);
  }
  return records;
}

Records records_of(const File& file) {
  coppice_file_header header;
  std::memcpy(&header, file.data(), sizeof header);
  Records records = {{header_record()}};
  std::vector<Record> entries;
  for (std::size_t i = 0; i < std::min<std::size_t>(header.chunk_count, kMaxEntries); ++i) {
    const std::size_t at = sizeof header + i * sizeof(coppice_file_chunk);
    if (at + sizeof(coppice_file_chunk) > file.size()) break;
    add_fields(entries.emplace_back(), at, FieldType::u32, 2);
    add_fields(entries.back(), at + offsetof(coppice_file_chunk, offset), FieldType::u64, 2);
    coppice_file_chunk chunk;
    std::memcpy(&chunk, &file[at], sizeof chunk);
    if (chunk.bytes > 0 && chunk.offset <= file.size() && chunk.bytes <= file.size() - chunk.offset)
      records.push_back(chunk_records(chunk));
  }
  records.push_back(std::move(entries));
  return records;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
  return coppice::test::mutate({.header_bytes = sizeof(coppice_file_header), .records_of = records_of}, data, size, max_size, seed);
}
