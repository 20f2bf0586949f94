// libFuzzer's mutator for .forest files: fields of the header, a species, a tile or an instance, singly and in pairs. The sums of the
// counts are made right most of the time; scene_fuzz makes the checksums right.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "coppice/scene_format.h"
#include "field_mutator.h"

namespace {

using coppice::test::add_fields;
using coppice::test::FieldType;
using coppice::test::File;
using coppice::test::Record;
using coppice::test::Records;

constexpr std::uint64_t kMaxRecords = 64;  // for each kind

coppice_scene_header header_of(const File& file) {
  coppice_scene_header header;
  std::memcpy(&header, file.data(), sizeof header);
  return header;
}

std::uint64_t tiles_at(const coppice_scene_header& header) {
  return sizeof header + std::uint64_t{header.species_count} * sizeof(coppice_scene_species) + header.path_bytes;
}

Record header_record() {
  Record record;
  add_fields(record, offsetof(coppice_scene_header, version), FieldType::u32, 4);
  add_fields(record, offsetof(coppice_scene_header, instance_count), FieldType::u64, 2);
  add_fields(record, offsetof(coppice_scene_header, square_min), FieldType::f32, 3);
  add_fields(record, offsetof(coppice_scene_header, reserved), FieldType::u32);
  return record;
}

Record instance_record(std::size_t at) {
  Record record;
  add_fields(record, at, FieldType::u16, 4);
  add_fields(record, at + offsetof(coppice_scene_instance, yaw), FieldType::u8, 2);
  add_fields(record, at + offsetof(coppice_scene_instance, tint), FieldType::u16);
  return record;
}

Records records_of(const File& file) {
  const coppice_scene_header header = header_of(file);
  std::vector<Record> species, tiles, scales, instances;
  for (std::uint64_t i = 0; i < header.species_count && i < kMaxRecords; ++i) {
    const std::size_t at = sizeof header + i * sizeof(coppice_scene_species);
    add_fields(species.emplace_back(), at, FieldType::u32, 2);
    add_fields(species.back(), at + offsetof(coppice_scene_species, sphere_center), FieldType::f32, 4);
  }
  for (std::uint64_t i = 0; i < header.tile_count && i < kMaxRecords; ++i) {
    const std::size_t at = tiles_at(header) + i * sizeof(coppice_scene_tile);
    add_fields(tiles.emplace_back(), at, FieldType::f32, 9);
    add_fields(tiles.back(), at + offsetof(coppice_scene_tile, instance_count), FieldType::u32, 3);
    add_fields(scales.emplace_back(), at + offsetof(coppice_scene_tile, scale_min), FieldType::f32, 3);
  }
  const std::uint64_t first = tiles_at(header) + std::uint64_t{header.tile_count} * sizeof(coppice_scene_tile);
  for (std::uint64_t i = 0; i < kMaxRecords && first + (i + 1) * sizeof(coppice_scene_instance) <= file.size(); ++i)
    instances.push_back(instance_record(first + i * sizeof(coppice_scene_instance)));
  return {{header_record()}, species, tiles, scales, instances};
}

/// Counts and lengths as the entries and the file have them.
void repair_sums(File& file) {
  coppice_scene_header header = header_of(file);
  header.file_bytes = file.size();
  std::uint64_t paths = 0, instances = 0;
  for (std::uint64_t i = 0; i < header.species_count; ++i) {
    const std::uint64_t at = sizeof header + i * sizeof(coppice_scene_species);
    if (at + sizeof(coppice_scene_species) > file.size()) return;
    coppice_scene_species species;
    std::memcpy(&species, &file[at], sizeof species);
    paths += species.path_bytes;
  }
  header.path_bytes = static_cast<std::uint32_t>(paths);
  for (std::uint64_t i = 0; i < header.tile_count; ++i) {
    const std::uint64_t at = tiles_at(header) + i * sizeof(coppice_scene_tile);
    if (at + sizeof(coppice_scene_tile) > file.size()) return;
    coppice_scene_tile tile;
    std::memcpy(&tile, &file[at], sizeof tile);
    instances += tile.instance_count;
  }
  header.instance_count = instances;
  std::memcpy(file.data(), &header, sizeof header);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
  return coppice::test::mutate({.header_bytes = sizeof(coppice_scene_header), .records_of = records_of, .repair = repair_sums}, data, size,
                               max_size, seed);
}
