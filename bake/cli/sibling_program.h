#pragma once

// Programs that `coppice` becomes for a command: coppice-forest for `view`, coppice-lab for `evaluate`.

#include <filesystem>
#include <string>
#include <vector>

#include "result.h"

namespace coppice::bake {

/// The program of this name beside this one, else in the first folder of PATH that has it.
/// errors  io: there is none; the message names the program and says where it was looked for
Result<std::filesystem::path> find_program(const std::string& name);

/// Replaces this process by the program. words: its arguments. Returns only where that fails.
Error start_program(const std::filesystem::path& program, std::vector<std::string> words);

}  // namespace coppice::bake
