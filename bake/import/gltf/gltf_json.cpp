#include "gltf_json.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

namespace coppice::bake::gltf_json {
namespace {

// No glTF needs deeper nesting; tinygltf reads `extras` by recursion.
constexpr std::size_t kMaxDepth = 64;

Result<void> check_depth(std::string_view text) {
  std::size_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return Error{Status::bad_file, "JSON nested deeper than 64 levels", i};
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return {};
}

}  // namespace

Error bad(const char* what, std::string place) {
  return Error{Status::bad_file, what, Error::kNoOffset, std::move(place)};
}

std::string element(const std::string& place, std::size_t index) {
  return place + "[" + std::to_string(index) + "]";
}

std::string member(const std::string& place, const char* name) {
  return place.empty() ? name : place + "." + name;
}

std::string extension_place(const std::string& place, const char* name) {
  return member(member(place, "extensions"), name);
}

Result<std::uint64_t> read_integer(const Json& object, const char* name, const std::string& place, std::uint64_t fallback) {
  const auto found = object.find(name);
  if (found == object.end()) return fallback;
  if (!found->is_number_unsigned()) return bad("not a whole number of 0 or more", member(place, name));
  const auto value = found->get<std::uint64_t>();
  return value;
}

Result<std::uint64_t> require_integer(const Json& object, const char* name, const std::string& place) {
  if (!object.contains(name)) return bad("missing member", member(place, name));
  return read_integer(object, name, place, 0);
}

Result<std::string> read_text(const Json& object, const char* name, const std::string& place) {
  const auto found = object.find(name);
  if (found == object.end()) return std::string();
  if (!found->is_string()) return bad("not a string", member(place, name));
  return found->get<std::string>();
}

Result<void> check_index(const Json& object, const char* name, const std::string& place, std::size_t limit) {
  if (!object.contains(name)) return {};
  COPPICE_TRY(index, read_integer(object, name, place, 0));
  if (index < limit) return {};
  return bad("index out of range", member(place, name) + " is " + std::to_string(index) + " of " + std::to_string(limit));
}

Result<std::uint64_t> require_index(const Json& object, const char* name, const std::string& place, std::size_t limit) {
  COPPICE_TRY(index, require_integer(object, name, place));
  COPPICE_CHECK(check_index(object, name, place, limit));
  return index;
}

Result<void> check_indices(const Json& object, const char* name, const std::string& place, std::size_t limit) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  if (!found->is_array()) return bad("not an array", member(place, name));
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& value = (*found)[i];
    const std::string where = element(member(place, name), i);
    if (!value.is_number_unsigned()) return bad("not a whole number of 0 or more", where);
    if (value.get<std::uint64_t>() >= limit)
      return bad("index out of range", where + " is " + std::to_string(value.get<std::uint64_t>()) + " of " + std::to_string(limit));
  }
  return {};
}

Result<void> check_numbers(const Json& object, const char* name, const std::string& place, std::size_t length) {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  const auto is_finite_number = [](const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); };
  if (found->is_array() && found->size() == length && std::all_of(found->begin(), found->end(), is_finite_number)) return {};
  return bad("wrong number or kind of components", member(place, name));
}

Result<const Json*> find_object(const Json& parent, const char* name, const std::string& place) {
  const auto found = parent.find(name);
  if (found == parent.end()) return nullptr;
  if (!found->is_object()) return bad("not an object", member(place, name));
  return &*found;
}

Result<const Json*> find_extension(const Json& parent, const char* name, const std::string& place) {
  COPPICE_TRY(extensions, find_object(parent, "extensions", place));
  if (extensions == nullptr) return nullptr;
  return find_object(*extensions, name, member(place, "extensions"));
}

Result<void> for_each_object(const Json& parent, const char* name, const std::string& place,
                             const std::function<Result<void>(const Json&, const std::string&)>& check) {
  const auto found = parent.find(name);
  if (found == parent.end()) return {};
  if (!found->is_array()) return bad("not an array", member(place, name));
  for (std::size_t i = 0; i < found->size(); ++i) {
    const std::string where = element(member(place, name), i);
    if (!(*found)[i].is_object()) return bad("not an object", where);
    COPPICE_CHECK(check((*found)[i], where));
  }
  return {};
}

Result<Json> parse(std::string_view text) {
  COPPICE_CHECK(check_depth(text));
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    return Error{Status::bad_file, "not valid JSON", error.byte};
  } catch (const Json::exception& error) {
    return bad("not valid JSON", error.what());
  }
}

}  // namespace coppice::bake::gltf_json
