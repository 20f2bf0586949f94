#pragma once

// Reads and fills structs of programs that were compiled with another version of the public headers, where a struct may be smaller or
// larger than ours. Every struct that the API reads or fills passes through here, so the rest of the library sees only structs of its own
// size.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "coppice/coppice.h"

namespace coppice {

/// Maximum size of a struct, now and later. A larger size means that struct_size was never set.
inline constexpr std::size_t kMaxStructBytes = 4096;

template <class T>
T zeroed_struct() {
  T zeroed{};
  zeroed.struct_size = sizeof(T);
  return zeroed;
}

/// Returns a struct as its *_init function leaves it.
template <class T>
T struct_defaults() {
  return zeroed_struct<T>();
}
template <>
coppice_context_desc struct_defaults();
template <>
coppice_scene_placement struct_defaults();
template <>
coppice_eye struct_defaults();
template <>
coppice_camera struct_defaults();
template <>
coppice_sun_desc struct_defaults();
template <>
coppice_frame struct_defaults();
template <>
coppice_wind struct_defaults();
template <>
coppice_ray struct_defaults();
template <>
coppice_leaf_layout struct_defaults();

/// Says what is wrong with the size of a struct, which may be null; empty if nothing is. name: of the argument, for the log
std::string struct_size_problem(const void* theirs, const char* name);
/// Says what is wrong with bytes behind the first `known_bytes` of a larger struct, which must all be 0; empty if nothing is.
std::string unknown_bytes_problem(const void* theirs, std::size_t known_bytes, const char* name);
std::string unknown_record_bytes_problem(const void* record, std::size_t known_bytes, std::size_t bytes, const std::string& name);

/// Reads a program's struct, which may be null. Fields that it lacks get their defaults. Returns what is wrong with it, or an empty string;
/// `ours` then holds the fields that could be read.
template <class T>
std::string read_struct(const T* theirs, const char* name, T& ours) {
  ours = struct_defaults<T>();
  std::string problem = struct_size_problem(theirs, name);
  if (theirs == nullptr || !problem.empty()) return problem;
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, theirs, sizeof bytes);
  std::memcpy(static_cast<void*>(&ours), theirs, bytes < sizeof(T) ? bytes : sizeof(T));
  ours.struct_size = sizeof(T);
  return unknown_bytes_problem(theirs, sizeof(T), name);
}

/// Says what is wrong with an array of records that lie `bytes` apart; empty if nothing is. records: may be null if count is 0
std::string records_problem(const void* records, std::size_t count, std::uint32_t bytes, const char* name);
/// Reads record `index`, which has no struct_size. Returns the same as read_struct. ours: holds defaults. before: records_problem() is
/// empty
template <class T>
std::string read_record(const void* records, std::size_t index, std::uint32_t bytes, const char* name, T& ours) {
  const auto* record = static_cast<const unsigned char*>(records) + index * bytes;
  std::memcpy(static_cast<void*>(&ours), record, bytes < sizeof(T) ? bytes : sizeof(T));
  return unknown_record_bytes_problem(record, sizeof(T), bytes, std::string(name) + "[" + std::to_string(index) + "]");
}

/// Copies `ours` to a program's struct as far as it reaches, and zeros the rest. theirs: struct_size_problem() is empty
void write_bytes(const void* ours, std::size_t our_bytes, void* theirs);
template <class T>
void write_struct(const T& ours, T* theirs) {
  write_bytes(&ours, sizeof(T), theirs);
}

/// Fills a struct of kind T with its defaults. theirs: not null
template <class T>
void init_struct(void* theirs, std::uint32_t bytes) {
  std::memcpy(theirs, &bytes, sizeof bytes);
  write_struct(struct_defaults<T>(), static_cast<T*>(theirs));
}
using StructInit = void (*)(void* theirs, std::uint32_t bytes);
/// Fills a struct with its defaults, or with zeros if this version does not know its kind. Does nothing if theirs is null or `bytes` is no
/// size of a struct. by_kind: for each kind its init_struct
void init_kind(std::span<const StructInit> by_kind, std::size_t kind, void* theirs, std::size_t bytes);

}  // namespace coppice
