#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "result.h"

namespace coppice::bake {

struct ProgramEnd {
  int exit_code = -1;  ///< -1: a signal ended it, or its time was up
  std::string out, err;
};

/// Runs a program of PATH to its end, without a shell, its standard input empty, and collects what it prints. It has a process group of its
/// own, so that Ctrl-C at the terminal does not cut it short.
/// words        the program and its arguments; not empty
/// max_seconds  after that it is killed
/// waiting      called every tenth of a second meanwhile; false: it is killed. May be empty
/// hidden       variables of the environment that it does not get: all whose names begin so
/// errors       io: there is no such program, or it cannot be started; `detail` is its name
Result<ProgramEnd> run_program(const std::vector<std::string>& words, double max_seconds, const std::function<bool()>& waiting = {},
                               std::span<const std::string_view> hidden = {});

}  // namespace coppice::bake
