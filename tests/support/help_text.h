#pragma once

// What a program's --help lists, for tests that compare it with documents and with completion.

#include <string>
#include <vector>

namespace coppice::test {

/// The entries of the part below "Subcommands:", in order.
std::vector<std::string> listed_commands(const std::string& help);

/// The names of all options, long and short, in order: "-o", "--output".
std::vector<std::string> listed_options(const std::string& help);

}  // namespace coppice::test
