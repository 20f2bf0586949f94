#pragma once

// Shared checks of fields for all headers. Each returns what is wrong, or an empty string.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>

namespace coppice {

/// The largest half.
inline constexpr float kMaxTint = 65504.0f;
/// For squared lengths and products of axes that should be 1 or 0.
inline constexpr float kUnitTolerance = 0.01f;
/// Larger elements of a matrix are a mistake, and would overflow later computations.
inline constexpr float kMaxMatrix = 1e10f;

/// Numbers of a struct that have the same range.
struct Field {
  const char* name;
  std::span<const float> values;
  float minimum, maximum;
};

std::string range_problem(const Field& field);
template <std::size_t count>
std::string range_problem(const Field (&fields)[count]) {
  for (const Field& field : fields)
    if (std::string problem = range_problem(field); !problem.empty()) return problem;
  return {};
}

std::string size_problem(const char* name, std::uint32_t value, std::uint32_t maximum);
std::string flag_problem(const char* name, std::uint32_t value);
/// Checks a field that later versions may use.
std::string reserved_problem(std::uint32_t value);

std::string double_problem(const char* name, std::span<const double> values, double maximum);

/// what: the required property, for the message
std::string unit_problem(const char* name, std::span<const float> values, const char* what = "not of unit length");

/// Uses the 2 x 2 minors of the first and the last two columns. m: 16 elements, column-major
template <class T>
double determinant(const T& m) {
  const auto minor = [&](std::size_t column, std::size_t a, std::size_t b) {
    return double{m[4 * column + a]} * double{m[4 * column + 4 + b]} - double{m[4 * column + b]} * double{m[4 * column + 4 + a]};
  };
  return minor(0, 0, 1) * minor(2, 2, 3) - minor(0, 0, 2) * minor(2, 1, 3) + minor(0, 0, 3) * minor(2, 1, 2) +
         minor(0, 1, 2) * minor(2, 0, 3) - minor(0, 1, 3) * minor(2, 0, 2) + minor(0, 2, 3) * minor(2, 0, 1);
}

template <class... Problems>
std::string first_of(Problems... problems) {
  std::string first;
  const auto take = [&](std::string& problem) {
    if (first.empty()) first = std::move(problem);
  };
  (take(problems), ...);
  return first;
}

}  // namespace coppice
