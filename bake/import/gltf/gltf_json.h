#pragma once

// Members of JSON objects, checked and named: what the screens of a glTF document are made of. `place` is where the object is, as in
// "accessors[3]"; an error's `detail` begins with the place of what is wrong. All errors are bad_file.

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
/// "place[index]".
std::string element(const std::string& place, std::size_t index);
/// "place.name".
std::string member(const std::string& place, const char* name);

/// A whole number of 0 or more; `fallback` where it is absent.
Result<std::uint64_t> read_integer(const Json& object, const char* name, const std::string& place, std::uint64_t fallback);
Result<std::uint64_t> require_integer(const Json& object, const char* name, const std::string& place);
/// A string; empty where it is absent.
Result<std::string> read_text(const Json& object, const char* name, const std::string& place);
/// An absent index is fine; a present one must be below `limit`.
Result<void> check_index(const Json& object, const char* name, const std::string& place, std::size_t limit);
Result<std::uint64_t> require_index(const Json& object, const char* name, const std::string& place, std::size_t limit);
/// An absent array is fine; in a present one every number must be below `limit`.
Result<void> check_indices(const Json& object, const char* name, const std::string& place, std::size_t limit);
/// An absent array is fine; a present one holds exactly `length` finite numbers.
Result<void> check_numbers(const Json& object, const char* name, const std::string& place, std::size_t length);
/// The object of that name; null where it is absent.
Result<const Json*> find_object(const Json& parent, const char* name, const std::string& place);
/// The object extensions.name; null where it is absent.
Result<const Json*> find_extension(const Json& parent, const char* name, const std::string& place);
/// Calls check(object, place) for every element of the array `name`; absent arrays are empty.
Result<void> for_each_object(const Json& parent, const char* name, const std::string& place,
                             const std::function<Result<void>(const Json&, const std::string&)>& check);

/// "place.extensions.name".
std::string extension_place(const std::string& place, const char* name);

/// Parses a document, nested no deeper than 64 levels (tinygltf reads some of it by recursion).
Result<Json> parse(std::string_view text);

}  // namespace coppice::bake::gltf_json
