#pragma once

// Checked access to the JSON of a glTF document. All errors are bad_file, and their `detail` begins with the place that is wrong.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include "result.h"

namespace coppice::bake {

/// An object of a document that outlives it. Members may be absent unless a function says otherwise.
class JsonObject {
 public:
  /// place  says where the object is, as in "accessors[3]"; empty for the document
  JsonObject(nlohmann::json& json, std::string place) : json_(&json), place_(std::move(place)) {}

  [[nodiscard]] nlohmann::json& json() const { return *json_; }
  [[nodiscard]] bool has(const std::string& name) const { return json_->contains(name); }
  /// Returns "place.name"; "place" without a name.
  [[nodiscard]] std::string place(const std::string& name = {}) const;
  /// An error whose detail is "place.name" and `more`, or "place.name is value".
  [[nodiscard]] Error bad(const char* what, const std::string& name = {}, const std::string& more = {}) const;
  [[nodiscard]] Error bad(const char* what, const std::string& name, std::uint64_t value) const {
    return bad(what, name, " is " + std::to_string(value));
  }

  /// Reads a whole number of 0 or more, which must be there or has a fallback.
  [[nodiscard]] Result<std::uint64_t> integer(const std::string& name) const;
  [[nodiscard]] Result<std::uint64_t> integer(const std::string& name, std::uint64_t fallback) const;
  /// Reads a string; empty if it is absent.
  [[nodiscard]] Result<std::string> text(const std::string& name) const;
  /// Reads a number below `limit`, which must be there.
  [[nodiscard]] Result<std::uint64_t> index(const std::string& name, std::size_t limit) const;
  [[nodiscard]] Result<void> check_index(const std::string& name, std::size_t limit) const;
  /// Checks that every number of an array is below `limit`.
  [[nodiscard]] Result<void> check_indices(const std::string& name, std::size_t limit) const;
  [[nodiscard]] Result<void> check_number(const std::string& name) const;
  /// Checks that an array holds exactly `length` finite numbers.
  [[nodiscard]] Result<void> check_numbers(const std::string& name, std::size_t length) const;
  [[nodiscard]] Result<std::optional<JsonObject>> object(const std::string& name) const;
  /// Finds the object extensions.name.
  [[nodiscard]] Result<std::optional<JsonObject>> extension(const std::string& name) const;
  /// Calls check(object) for every element of an array.
  [[nodiscard]] Result<void> for_each(const std::string& name, const std::function<Result<void>(const JsonObject&)>& check) const;
  /// Calls check(name) for every member of this object.
  [[nodiscard]] Result<void> for_each_name(const std::function<Result<void>(const std::string&)>& check) const;

 private:
  nlohmann::json* json_;
  std::string place_;
};

/// Parses a document that nests no deeper than 64 levels (nlohmann writes JSON, and tinygltf reads some of it, by recursion).
Result<nlohmann::json> parse_gltf_json(std::string_view text);

}  // namespace coppice::bake
