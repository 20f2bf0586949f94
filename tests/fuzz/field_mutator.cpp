#include "field_mutator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace coppice::test {
namespace {

using Random = std::minstd_rand;

constexpr std::array<std::size_t, 5> kBytes = {1, 2, 4, 8, 4};

template <std::size_t count>
auto any_of(const std::array<float, count>& values, Random& random) {
  return values[random() % count];
}

float interesting_float(Random& random) {
  using Limits = std::numeric_limits<float>;
  static const std::array<float, 26> kValues = {0.0f,
                                                -0.0f,
                                                1.0f,
                                                -1.0f,
                                                1e-45f,
                                                -1e-45f,
                                                1e-39f,
                                                Limits::min(),
                                                1e-20f,
                                                1e-6f,
                                                0.5f,
                                                1.0000001f,
                                                1.5f,
                                                2.0f,
                                                255.0f,
                                                1e3f,
                                                1e4f,
                                                1e6f,
                                                1e7f,
                                                1e9f,
                                                1e20f,
                                                Limits::max(),
                                                Limits::lowest(),
                                                Limits::infinity(),
                                                -Limits::infinity(),
                                                Limits::quiet_NaN()};
  return any_of(kValues, random);
}

std::uint64_t interesting_integer(Random& random) {
  static constexpr std::array<std::uint64_t, 20> kValues = {
      0, 1, 2, 3, 7, 8, 15, 16, 255, 256, 511, 512, 0x7fff, 0x8000, 0xffff, 1u << 16, 1u << 20, 1u << 26, 0x7fffffff, ~std::uint64_t{0}};
  return kValues[random() % kValues.size()];
}

/// Another value for what stands there.
std::uint64_t new_value(std::uint64_t old, FieldType type, Random& random) {
  if (type == FieldType::f32) {
    const auto bits = static_cast<std::uint32_t>(old);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    switch (random() % 8) {
      case 0:
        value = std::nextafter(value, INFINITY);
        break;
      case 1:
        value = std::nextafter(value, -INFINITY);
        break;
      case 2:
        value = -value;
        break;
      case 3:
        value *= any_of(std::array<float, 4>{2.0f, 0.5f, 1e6f, 1e-6f}, random);
        break;
      default:
        value = interesting_float(random);
    }
    std::uint32_t changed;
    std::memcpy(&changed, &value, sizeof changed);
    return changed;
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
std::optional<std::uint64_t> get(const std::vector<std::uint8_t>& file, const Field& field) {
  const std::size_t bytes = kBytes[static_cast<std::size_t>(field.type)];
  if (field.at > file.size() || bytes > file.size() - field.at) return {};
  std::uint64_t value = 0;
  std::memcpy(&value, &file[field.at], bytes);
  return value;
}

void put(std::vector<std::uint8_t>& file, const Field& field, std::uint64_t value) {
  if (get(file, field)) std::memcpy(&file[field.at], &value, kBytes[static_cast<std::size_t>(field.type)]);
}

void change_field(std::vector<std::uint8_t>& file, const std::vector<Record>& kind, const Record& record, Random& random) {
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

}  // namespace

void add_fields(Record& record, std::size_t at, FieldType type, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) record.push_back({at + i * kBytes[static_cast<std::size_t>(type)], type});
}

void change_fields(std::vector<std::uint8_t>& file, const Records& records, Random& random) {
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

std::size_t put_mutant(const std::vector<std::uint8_t>& file, std::uint8_t* data, std::size_t max_size) {
  const std::size_t bytes = std::min(file.size(), max_size);
  if (bytes > 0) std::memcpy(data, file.data(), bytes);
  return bytes;
}

}  // namespace coppice::test
