#pragma once

// Shared by readers of files: structs copied out of bytes, counts held to their limits, errors that name field and byte.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

#include "result.h"

namespace coppice {

inline Error bad_field(const char* what, std::uint64_t offset, std::string detail = {}) {
  return Error{Status::bad_file, what, offset, std::move(detail)};
}

/// Copies a T; the caller has checked the length.
template <class T>
T copy_at(std::span<const std::uint8_t> bytes, std::uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

/// A count, its limits, and its place in its struct.
struct CountField {
  const char* name;
  std::uint64_t value, minimum, maximum;
  std::size_t offset;
};

/// at  offset of the struct in the file. errors  bad_file: the first count outside its limits
inline Result<void> check_count_fields(std::span<const CountField> fields, std::uint64_t at) {
  for (const CountField& field : fields)
    if (field.value < field.minimum || field.value > field.maximum)
      return bad_field(field.name, at + field.offset,
                       std::to_string(field.value) + " is not in " + std::to_string(field.minimum) + ".." + std::to_string(field.maximum));
  return {};
}

}  // namespace coppice
