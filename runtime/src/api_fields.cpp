#include "api_fields.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "coppice/coppice.h"

namespace coppice {
namespace {

std::string numbered(const Field& field, std::size_t index) {
  return field.values.size() == 1 ? field.name : std::string(field.name) + "[" + std::to_string(index) + "]";
}

}  // namespace

std::string range_problem(const Field& field) {
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    const float value = field.values[i];
    if (value >= field.minimum && value <= field.maximum) continue;
    if (!std::isfinite(value)) return numbered(field, i) + " is not finite";
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), " is %g: outside %g to %g", static_cast<double>(value), static_cast<double>(field.minimum),
                  static_cast<double>(field.maximum));
    return numbered(field, i) + text.data();
  }
  return {};
}

std::string unit_problem(const char* name, std::span<const float> values, const char* what) {
  float sum = 0;
  for (const float value : values) sum += value * value;
  if (std::abs(sum - 1.0f) < kUnitTolerance) return {};
  const float maximum = 1.0f + kUnitTolerance;
  const std::string problem = range_problem({name, values, -maximum, maximum});
  return problem.empty() ? std::string(name) + " is " + what : problem + ", so it is " + what;
}

std::string double_problem(const char* name, std::span<const double> values, double maximum) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::abs(values[i]) <= maximum) continue;
    const std::string field = std::string(name) + "[" + std::to_string(i) + "]";
    if (!std::isfinite(values[i])) return field + " is not finite";
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), " is %g: outside %g to %g", values[i], -maximum, maximum);
    return field + text.data();
  }
  return {};
}

std::string size_problem(const char* name, std::uint32_t value, std::uint32_t maximum) {
  if (value >= 1 && value <= maximum) return {};
  return std::string(name) + " is " + std::to_string(value) + ": outside 1 to " + std::to_string(maximum);
}

std::string flag_problem(const char* name, std::uint32_t value) {
  return value <= COPPICE_TRUE ? "" : std::string(name) + " is " + std::to_string(value) + ", neither 0 nor 1";
}

std::string reserved_problem(std::uint32_t value) {
  return value == 0 ? "" : "reserved is " + std::to_string(value) + ": must be 0";
}

}  // namespace coppice
