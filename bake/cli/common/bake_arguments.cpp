#include "bake_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

namespace coppice::bake {

void add_bake_options(CLI::App& command, BakeRequest& request, std::initializer_list<OptionGroup> groups) {
  for (const BakeOption& option : bake_option_table()) {
    if (groups.size() > 0 && std::ranges::find(groups, option.group) == groups.end()) continue;
    const std::string name = "--" + option.name;
    const auto set = [&option, &request, name](const std::string& text) {
      if (const auto done = option.set(request, text); !done) throw CLI::ValidationError(name, done.error().detail);
    };
    if (option.type.empty()) {
      command.add_flag_callback(
          name, [set] { set("true"); }, option.help);
      continue;
    }
    CLI::Option* added = command.add_option_function<std::string>(name, set, option.help)->type_name(option.type);
    if (const auto value = option.get({})) added->default_str(*value);
  }
}

void check_bake_request(const BakeRequest& request) {
  if (const auto possible = check_areas(request.options); !possible) throw CLI::ValidationError("--areas", possible.error().what);
}

}  // namespace coppice::bake
