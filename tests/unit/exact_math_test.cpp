// Functions of <cmath> in programs that link the baker: their bits are committed, so that every processor, compiler and C library on which
// this test passes bakes alike as far as they go.

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "parallel_for.h"

namespace exact_math_test {

/// Values that no compiler can work out before.
double hidden(double value) {
  static volatile double place;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables)
  place = value;
  return place;
}

/// FNV-1a over the bits of results at a hundred thousand places of a range.
std::uint64_t hash_of(const std::function<double(double)>& function, double low, double high) {
  constexpr int kPlaces = 100'000;
  std::uint64_t hash = 14695981039346656037u;
  for (int i = 0; i < kPlaces; ++i) {
    const auto bits = std::bit_cast<std::uint64_t>(function(hidden(low + (high - low) * i / kPlaces)));
    for (int byte = 0; byte < 8; ++byte) hash = (hash ^ ((bits >> (8 * byte)) & 0xffu)) * 1099511628211u;
  }
  return hash;
}

TEST(ExactMath, BitsAreThoseThatAreCommitted) {
  struct Case {
    const char* name;
    std::function<double(double)> function;
    double low, high;
    std::uint64_t hash;
  };
  const std::vector<Case> cases = {
      {"sin", [](double x) { return std::sin(x); }, -20, 20, 15944410712729354229u},
      {"cos", [](double x) { return std::cos(x); }, -20, 20, 1927436760782555700u},
      {"acos", [](double x) { return std::acos(x); }, -1, 1, 5876466202093264517u},
      {"atan2", [](double x) { return std::atan2(x, hidden(0.7)); }, -3, 3, 13191382918668269032u},
      {"exp", [](double x) { return std::exp(x); }, -20, 20, 16414984830661943570u},
      {"exp2", [](double x) { return std::exp2(x); }, -20, 20, 9277384257659287893u},
      {"log", [](double x) { return std::log(x); }, 1e-6, 100, 11735493723483513337u},
      {"log2", [](double x) { return std::log2(x); }, 1e-6, 100, 626389829559578663u},
      {"log10", [](double x) { return std::log10(x); }, 1e-6, 100, 12641855431010664561u},
      {"pow", [](double x) { return std::pow(x, hidden(2.2)); }, 0, 2, 11174817750079912327u},
      {"cbrt", [](double x) { return std::cbrt(x); }, -100, 100, 11904219299758007535u},
      {"powf", [](double x) { return static_cast<double>(std::pow(static_cast<float>(x), 2.4f)); }, 0, 2, 4186733188941785880u},
      {"sinf", [](double x) { return static_cast<double>(std::sin(static_cast<float>(x))); }, -20, 20, 6614251907076164222u},
      {"logf", [](double x) { return static_cast<double>(std::log(static_cast<float>(x))); }, 1e-6, 100, 15784752511460521305u},
  };
  for (const Case& function : cases) EXPECT_EQ(hash_of(function.function, function.low, function.high), function.hash) << function.name;
}

TEST(ExactMath, ValuesAreWithinAUnitInTheLastPlace) {
  const auto expect_near = [](double value, long double exact, const char* name, double x) {
    const double unit = std::nextafter(std::abs(value), INFINITY) - std::abs(value);
    EXPECT_LE(std::abs(static_cast<long double>(value) - exact), 1.001L * unit) << name << " of " << x;
  };
  for (int i = 1; i < 20'000; ++i) {
    const double x = hidden(0.0013 * i);
    const long double wide = x;
    expect_near(std::sin(x), std::sin(wide), "sin", x);
    expect_near(std::cos(x), std::cos(wide), "cos", x);
    expect_near(std::exp(x), std::exp(wide), "exp", x);
    expect_near(std::log2(x), std::log2(wide), "log2", x);
    expect_near(std::pow(x, hidden(2.2)), std::pow(wide, static_cast<long double>(2.2)), "pow", x);
    const auto narrow = static_cast<float>(x);
    EXPECT_EQ(std::pow(narrow, 2.4f), static_cast<float>(std::pow(static_cast<long double>(narrow), static_cast<long double>(2.4f)))) << x;
  }
}

TEST(ExactMath, ExactValuesAreExact) {
  for (int power = -60; power <= 60; ++power) {
    EXPECT_EQ(std::log2(std::ldexp(hidden(1.0), power)), power);
    EXPECT_EQ(std::exp2(hidden(power)), std::ldexp(1.0, power));
  }
  for (const double one : {std::cos(hidden(0.0)), std::exp(hidden(0.0))}) EXPECT_EQ(one, 1.0);
  for (const double zero : {std::sin(hidden(0.0)), std::acos(hidden(1.0)), std::log(hidden(1.0))}) EXPECT_EQ(zero, 0.0);
  EXPECT_EQ(std::pow(static_cast<float>(hidden(0.0)), 2.4f), 0.0f);
  EXPECT_EQ(std::pow(static_cast<float>(hidden(1.0)), 2.4f), 1.0f);
  EXPECT_EQ(std::pow(static_cast<float>(hidden(-2.0)), 3.0f), -8.0f);
  EXPECT_EQ(std::pow(hidden(3.0), 2.0), 9.0);
}

}  // namespace exact_math_test
