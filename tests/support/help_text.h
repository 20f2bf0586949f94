#pragma once

// What a program's --help lists, for tests that compare it with documents and with completion.

#include <map>
#include <string>
#include <vector>

namespace coppice::test {

/// The entries of the part below "Subcommands:", in order.
std::vector<std::string> listed_commands(const std::string& help);

/// The names of all options, long and short, in order: "-o", "--output".
std::vector<std::string> listed_options(const std::string& help);

/// Each long option's entry in one line, without its names: "PX  Side of an item buffer in pixels; from 16 to 2048 [256]".
std::map<std::string, std::string> option_texts(const std::string& help);

}  // namespace coppice::test
