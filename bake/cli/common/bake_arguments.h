#pragma once

// The options of bake_option_table() on a command line.

#include <initializer_list>

#include "option_table.h"

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace coppice::bake {

/// Adds the options of some groups, all without any. `request` gets what is given when the command is parsed, and must outlive the command.
void add_bake_options(CLI::App& command, BakeRequest& request, std::initializer_list<OptionGroup> groups = {});

/// Throws CLI::ValidationError for options that do not go together.
void check_bake_request(const BakeRequest& request);

}  // namespace coppice::bake
