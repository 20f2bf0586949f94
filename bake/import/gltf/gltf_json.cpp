#include "gltf_json.h"

#include <algorithm>
#include <cmath>

namespace coppice::bake {
namespace {

using Json = nlohmann::json;

// No glTF needs deeper nesting.
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

std::string in_brackets(std::size_t index) {
  return "[" + std::to_string(index) + "]";
}

std::string of_limit(std::uint64_t index, std::size_t limit) {
  return " is " + std::to_string(index) + " of " + std::to_string(limit);
}

}  // namespace

std::string JsonObject::place(const std::string& name) const {
  return place_.empty() || name.empty() ? place_ + name : place_ + "." + name;
}

Error JsonObject::bad(const char* what, const std::string& name, const std::string& more) const {
  return Error{Status::bad_file, what, Error::kNoOffset, place(name) + more};
}

Result<std::uint64_t> JsonObject::integer(const std::string& name) const {
  if (!has(name)) return bad("missing member", name);
  const Json& value = (*json_)[name];
  if (!value.is_number_unsigned()) return bad("not a whole number of 0 or more", name);
  return value.get<std::uint64_t>();
}

Result<std::uint64_t> JsonObject::integer(const std::string& name, std::uint64_t fallback) const {
  return has(name) ? integer(name) : fallback;
}

Result<std::string> JsonObject::text(const std::string& name) const {
  if (!has(name)) return std::string();
  if (!(*json_)[name].is_string()) return bad("not a string", name);
  return (*json_)[name].get<std::string>();
}

Result<std::uint64_t> JsonObject::index(const std::string& name, std::size_t limit) const {
  COPPICE_TRY(index, integer(name));
  COPPICE_CHECK(check_index(name, limit));
  return index;
}

Result<void> JsonObject::check_index(const std::string& name, std::size_t limit) const {
  COPPICE_TRY(index, integer(name, 0));
  return index < limit || !has(name) ? Result<void>() : bad("index out of range", name, of_limit(index, limit));
}

Result<void> JsonObject::check_indices(const std::string& name, std::size_t limit) const {
  if (!has(name)) return {};
  const Json& values = (*json_)[name];
  if (!values.is_array()) return bad("not an array", name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].is_number_unsigned()) return bad("not a whole number of 0 or more", name + in_brackets(i));
    const auto index = values[i].get<std::uint64_t>();
    if (index >= limit) return bad("index out of range", name + in_brackets(i), of_limit(index, limit));
  }
  return {};
}

Result<void> JsonObject::check_number(const std::string& name) const {
  return !has(name) || (*json_)[name].is_number() ? Result<void>() : bad("not a number", name);
}

Result<void> JsonObject::check_numbers(const std::string& name, std::size_t length) const {
  if (!has(name)) return {};
  const Json& values = (*json_)[name];
  const auto is_finite_number = [](const Json& value) { return value.is_number() && std::isfinite(value.get<double>()); };
  if (values.is_array() && values.size() == length && std::ranges::all_of(values, is_finite_number)) return {};
  return bad("wrong number or kind of components", name);
}

Result<std::optional<JsonObject>> JsonObject::object(const std::string& name) const {
  if (!has(name)) return std::optional<JsonObject>();
  if (!(*json_)[name].is_object()) return bad("not an object", name);
  return std::optional(JsonObject((*json_)[name], place(name)));
}

Result<std::optional<JsonObject>> JsonObject::extension(const std::string& name) const {
  COPPICE_TRY(extensions, object("extensions"));
  return extensions ? extensions->object(name) : std::optional<JsonObject>();
}

Result<void> JsonObject::for_each(const std::string& name, const std::function<Result<void>(const JsonObject&)>& check) const {
  if (!has(name)) return {};
  Json& values = (*json_)[name];
  if (!values.is_array()) return bad("not an array", name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const JsonObject each(values[i], place(name) + in_brackets(i));
    if (!values[i].is_object()) return each.bad("not an object");
    COPPICE_CHECK(check(each));
  }
  return {};
}

Result<void> JsonObject::for_each_name(const std::function<Result<void>(const std::string&)>& check) const {
  for (const auto& member : json_->items()) COPPICE_CHECK(check(member.key()));
  return {};
}

Result<Json> parse_gltf_json(std::string_view text) {
  COPPICE_CHECK(check_depth(text));
  try {
    return Json::parse(text.begin(), text.end());
  } catch (const Json::parse_error& error) {
    return Error{Status::bad_file, "not valid JSON", error.byte};
  } catch (const Json::exception& error) {
    return Error{Status::bad_file, "not valid JSON", Error::kNoOffset, error.what()};
  }
}

}  // namespace coppice::bake
