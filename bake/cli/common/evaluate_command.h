#pragma once

// `coppice evaluate`, which is done by another program: what the help of `coppice` and that program both say.

namespace coppice::bake {

inline constexpr const char* kLabProgram = "coppice-lab";
inline constexpr const char* kEvaluateCommand = "evaluate";
inline constexpr const char* kEvaluateAbout = "Measure what simplifying does to a plant, against other methods";

}  // namespace coppice::bake
