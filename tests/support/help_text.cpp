#include "help_text.h"

#include <regex>
#include <sstream>

namespace coppice::test {
namespace {

// An entry begins two columns in; its text goes on further in.
const std::regex kCommand("  ([a-z][a-z-]*) .*"), kOption("  ((-[a-zA-Z], )?--[a-z-]+(, --[a-z-]+)*)(.*)"), kName("--?[a-zA-Z-]+");

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::sregex_iterator name(text.begin(), text.end(), kName), end; name != end; ++name) names.push_back(name->str());
  return names;
}

}  // namespace

std::vector<std::string> listed_commands(const std::string& help) {
  std::vector<std::string> commands;
  std::istringstream lines(help);
  bool is_below = false;
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    is_below = line == "Subcommands:" || (is_below && !line.empty());
    if (is_below && std::regex_match(line, found, kCommand)) commands.push_back(found[1]);
  }
  return commands;
}

std::vector<std::string> listed_options(const std::string& help) {
  std::vector<std::string> options;
  std::istringstream lines(help);
  std::smatch found;
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, found, kOption))
      for (const std::string& name : names_in(found[1])) options.push_back(name);
  return options;
}

}  // namespace coppice::test
