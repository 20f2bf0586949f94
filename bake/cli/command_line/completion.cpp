#include "completion.h"

#include <algorithm>
#include <numeric>
#include <regex>
#include <set>

#include <CLI/CLI.hpp>

namespace coppice::command_line {
namespace {

std::string line(const std::string& word, const std::string& text = {}) {
  return word + '\t' + text + '\n';
}

/// Adds a line for each member of the first set in what CLI11 says of an option's checks: "{on,off}", and of a map "{on->1,off->0}".
void add_members(const std::string& checks, std::set<std::string>& lines) {
  const std::size_t begin = checks.find('{'), end = checks.find('}', begin);
  if (begin == std::string::npos || end == std::string::npos) return;
  for (const std::string& member : CLI::detail::split(checks.substr(begin + 1, end - begin - 1), ','))
    lines.insert(line(member.substr(0, member.find("->"))));
}

/// Adds lines for one of the alternatives in a type name.
void add_alternative(const std::string& text, std::set<std::string>& lines) {
  static const std::regex form(R"((?:NAME=)?(?:(FOLDER|.+/)|(FILE|[A-Z]+(\.[a-z0-9]+))|([a-z0-9_-]+))(?:,\.\.\.)?)");
  std::smatch found;
  if (!std::regex_match(text, found, form)) return;
  if (found[1].matched || found[2].matched) lines.insert(line(":folder"));
  if (found[2].matched) lines.insert(line(":file", found[3]));
  if (found[4].matched) lines.insert(line(found[4]));
}

/// The lines for a value of the option, which begins in the current word at `begin`.
std::string value_lines(const CLI::Option& option, const std::string& current, std::size_t begin = 0) {
  // CLI11 has a type and what its values are checked for in one text: "KIND:{on,off}".
  const std::string type = option.get_type_name();
  if (type.starts_with("NAME=")) {
    begin = current.find('=', begin) + 1;
    if (begin == 0) return "";
  }
  const char separator = option.get_delimiter();
  if (separator != 0) begin = std::max(begin, current.rfind(separator) + 1);  // npos + 1 is 0
  const std::size_t checks = std::min(type.find(':'), type.size());
  std::set<std::string> lines;
  add_members(type.substr(checks), lines);
  for (const std::string& alternative : CLI::detail::split(type.substr(0, checks), '|')) add_alternative(alternative, lines);
  const std::string before = begin > 0 ? line(":before", current.substr(0, begin)) : "";
  return std::accumulate(lines.begin(), lines.end(), before + (separator != 0 ? line(":list") : ""));
}

std::string option_lines(const CLI::App& command) {
  std::string text;
  for (const CLI::Option* option : command.get_options()) {
    const std::string about = first_clause(option->get_description());
    for (const std::string& name : option->get_snames()) text += line("-" + name, about);
    for (const std::string& name : option->get_lnames()) text += line("--" + name, about);
  }
  return text;
}

std::string command_lines(const CLI::App& app) {
  std::string text;
  for (const CLI::App* command : app.get_subcommands({})) text += line(command->get_name(), first_clause(command->get_description()));
  return text;
}

/// Null: there is none of that name, or it is a flag.
const CLI::Option* option_with_value(const CLI::App& command, const std::string& name) {
  const CLI::Option* option = command.get_option_no_throw(name);
  return option != nullptr && option->get_items_expected_max() > 0 ? option : nullptr;
}

/// The lines for a word that is no option, behind so many others.
std::string place_lines(const CLI::App& command, std::size_t before, const std::string& current) {
  std::size_t place = 0;
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional() && (place++ == before || (option->get_items_expected_max() > 1 && place <= before)))
      return value_lines(*option, current);
  return command_lines(command);
}

}  // namespace

std::string first_clause(const std::string& text) {
  static const std::string ends = ".;:[";
  for (std::size_t at = text.find_first_of(ends); at != std::string::npos; at = text.find_first_of(ends, at + 1)) {
    if (text[at] == '[' && at > 0) return text.substr(0, at - 1);
    const bool ends_word = at + 1 == text.size() || text[at + 1] == ' ' || text[at + 1] == '\n';
    if (ends_word && (text[at] != ':' || text.find(' ') < at)) return text.substr(0, at);
  }
  return text;
}

std::string completions(const CLI::App& app, std::vector<std::string> words) {
  const std::string current = words.empty() ? "" : words.back();
  if (!words.empty()) words.pop_back();
  const CLI::App* command = &app;
  const CLI::Option* option = nullptr;  // whose value comes next
  std::size_t places = 0;
  bool only_places = false;
  for (const std::string& word : words) {
    if (option != nullptr) {
      option = nullptr;
    } else if (!only_places && word.size() > 1 && word.starts_with('-')) {
      only_places = word == "--";
      option = option_with_value(*command, word);
    } else if (!command->get_subcommands({}).empty()) {
      const auto named = command->get_subcommands([&word](const CLI::App* each) { return each->get_name() == word; });
      if (named.empty()) return "";
      command = named.front();
    } else {
      ++places;
    }
  }
  if (option != nullptr) return value_lines(*option, current);
  if (only_places || !current.starts_with('-')) return place_lines(*command, places, current);
  const std::size_t equals = current.find('=');
  if (equals == std::string::npos) return option_lines(*command);
  option = option_with_value(*command, current.substr(0, equals));
  return option != nullptr ? value_lines(*option, current, equals + 1) : "";
}

}  // namespace coppice::command_line
