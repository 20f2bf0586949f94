#pragma once

// Checked access to members of JSON objects, for the screens of a glTF document. `place` says where the object is, as in "accessors[3]"; an
// error's `detail` begins with the place that is wrong. All errors are bad_file.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "result.h"

namespace coppice::bake::gltf_json {

using Json = nlohmann::json;

Error bad(const char* what, std::string place);
/// Returns "place[index]".
std::string element(const std::string& place, std::size_t index);
/// Returns "place.name".
std::string member(const std::string& place, const char* name);

/// Reads a whole number of 0 or more; `fallback` if it is absent.
Result<std::uint64_t> read_integer(const Json& object, const char* name, const std::string& place, std::uint64_t fallback);
Result<std::uint64_t> require_integer(const Json& object, const char* name, const std::string& place);
/// Reads a string; empty if it is absent.
Result<std::string> read_text(const Json& object, const char* name, const std::string& place);
/// Checks that an index, if present, is below `limit`.
Result<void> check_index(const Json& object, const char* name, const std::string& place, std::size_t limit);
Result<std::uint64_t> require_index(const Json& object, const char* name, const std::string& place, std::size_t limit);
/// Checks that every number of an array, if present, is below `limit`.
Result<void> check_indices(const Json& object, const char* name, const std::string& place, std::size_t limit);
/// Checks that an array, if present, holds exactly `length` finite numbers.
Result<void> check_numbers(const Json& object, const char* name, const std::string& place, std::size_t length);
/// Finds the object of that name; null if it is absent.
Result<const Json*> find_object(const Json& parent, const char* name, const std::string& place);
/// Finds the object extensions.name; null if it is absent.
Result<const Json*> find_extension(const Json& parent, const char* name, const std::string& place);
/// Calls check(object, place) for every element of the array `name`; an absent array is empty.
Result<void> for_each_object(const Json& parent, const char* name, const std::string& place,
                             const std::function<Result<void>(const Json&, const std::string&)>& check);

/// Returns "place.extensions.name".
std::string extension_place(const std::string& place, const char* name);

/// Parses a document that nests no deeper than 64 levels (tinygltf reads some of it by recursion).
Result<Json> parse(std::string_view text);

}  // namespace coppice::bake::gltf_json
