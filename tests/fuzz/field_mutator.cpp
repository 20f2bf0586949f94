#include "field_mutator.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstring>
#include <optional>
#include <random>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace coppice::test {
namespace {

using Random = std::minstd_rand;

constexpr std::array<std::size_t, 5> kBytes = {1, 2, 4, 8, 4};

template <class T, std::size_t count>
T any_of(const std::array<T, count>& values, Random& random) {
  return values[random() % count];
}

float interesting_float(Random& random) {
  static constexpr std::array<float, 26> kValues = {0.0f,  -0.0f, 1.0f,       -1.0f,   1e-45f,   -1e-45f,  1e-39f,    FLT_MIN, 1e-20f,
                                                    1e-6f, 0.5f,  1.0000001f, 1.5f,    2.0f,     255.0f,   1e3f,      1e4f,    1e6f,
                                                    1e7f,  1e9f,  1e20f,      FLT_MAX, -FLT_MAX, INFINITY, -INFINITY, NAN};
  return any_of(kValues, random);
}

std::uint64_t interesting_integer(Random& random) {
  static constexpr std::array<std::uint64_t, 20> kValues = {
      0, 1, 2, 3, 7, 8, 15, 16, 255, 256, 511, 512, 0x7fff, 0x8000, 0xffff, 1u << 16, 1u << 20, 1u << 26, 0x7fffffff, ~std::uint64_t{0}};
  return any_of(kValues, random);
}

/// Another value for what stands there.
std::uint64_t new_value(std::uint64_t old, FieldType type, Random& random) {
  if (type == FieldType::f32) {
    const auto value = std::bit_cast<float>(static_cast<std::uint32_t>(old));
    const auto changed = [&] {
      switch (random() % 8) {
        case 0:
          return std::nextafter(value, INFINITY);
        case 1:
          return std::nextafter(value, -INFINITY);
        case 2:
          return -value;
        case 3:
          return value * any_of(std::array{2.0f, 0.5f, 1e6f, 1e-6f}, random);
        default:
          return interesting_float(random);
      }
    };
    return std::bit_cast<std::uint32_t>(changed());
  }
  switch (random() % 6) {
    case 0:
      return old + 1;
    case 1:
      return old - 1;
    case 2:
      return old ^ std::uint64_t{1} << random() % (8 * kBytes[static_cast<std::size_t>(type)]);
    case 3:
      return random();
    default:
      return interesting_integer(random);
  }
}

/// What stands in a field, or nothing if it is not in the file.
std::optional<std::uint64_t> get(const File& file, const Field& field) {
  const std::size_t bytes = kBytes[static_cast<std::size_t>(field.type)];
  if (field.at > file.size() || bytes > file.size() - field.at) return {};
  std::uint64_t value = 0;
  std::memcpy(&value, &file[field.at], bytes);
  return value;
}

void put(File& file, const Field& field, std::uint64_t value) {
  if (get(file, field)) std::memcpy(&file[field.at], &value, kBytes[static_cast<std::size_t>(field.type)]);
}

void change_field(File& file, const std::vector<Record>& kind, const Record& record, Random& random) {
  if (record.empty()) return;
  const std::size_t chosen = random() % record.size();
  const auto old = get(file, record[chosen]);
  if (!old) return;
  std::uint64_t value = new_value(*old, record[chosen].type, random);
  if (random() % 8 == 0) value = get(file, record[random() % record.size()]).value_or(value);
  put(file, record[chosen], value);
  if (random() % 6 != 0) return;
  for (const Record& other : kind)
    if (chosen < other.size()) put(file, other[chosen], value);
}

void change_fields(File& file, const Records& records, Random& random) {
  const std::size_t count = 1 + random() % 3;
  const std::vector<Record>* kind = nullptr;
  const Record* record = nullptr;
  for (std::size_t i = 0; i < count; ++i) {
    if (record == nullptr || random() % 3 == 0) {
      kind = &records[random() % records.size()];
      if (kind->empty()) continue;
      record = &(*kind)[random() % kind->size()];
    }
    change_field(file, *kind, *record, random);
  }
}

}  // namespace

void add_fields(Record& record, std::size_t at, FieldType type, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) record.push_back({at + i * kBytes[static_cast<std::size_t>(type)], type});
}

std::size_t mutate(const FileFormat& format, std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed) {
  Random random(seed);
  if (size < format.header_bytes || random() % 4 == 0) return LLVMFuzzerMutate(data, size, max_size);
  File file(data, data + size);
  change_fields(file, format.records_of(file), random);
  if (format.repair != nullptr && random() % 8 != 0) format.repair(file);
  const std::size_t bytes = std::min(file.size(), max_size);
  if (bytes > 0) std::memcpy(data, file.data(), bytes);
  return bytes;
}

}  // namespace coppice::test
