#include "completion.h"

#include <algorithm>
#include <regex>

#include <CLI/CLI.hpp>

namespace coppice::command_line {
namespace {

std::vector<std::string> split(const std::string& text, char between) {
  std::vector<std::string> parts;
  for (std::size_t at = 0; at <= text.size();) {
    parts.push_back(text.substr(at, text.find(between, at) - at));
    at += parts.back().size() + 1;
  }
  return parts;
}

void add_once(std::vector<std::string>& words, const std::string& word) {
  if (std::ranges::find(words, word) == words.end()) words.push_back(word);
}

/// The members of the first set in what CLI11 says of an option's checks: "{on,off}", and of a map "{on->1,off->0}".
void add_members(const std::string& checks, std::vector<std::string>& words) {
  const std::size_t begin = checks.find('{'), end = checks.find('}', begin);
  if (begin == std::string::npos || end == std::string::npos) return;
  for (const std::string& member : split(checks.substr(begin + 1, end - begin - 1), ','))
    add_once(words, member.substr(0, member.find("->")));
}

/// One alternative of a type name.
void add_alternative(std::string name, ValueWords& value) {
  static const std::regex ending_form(R"([A-Z]+(\.[a-z0-9]+))"), word_form("[a-z0-9_-]+");
  static const std::string name_first = "NAME=", list_last = ",...";
  if (name.starts_with(name_first)) {
    value.is_named = true;
    name.erase(0, name_first.size());
  }
  if (name.ends_with(list_last)) name.erase(name.size() - list_last.size());
  std::smatch found;
  if (name == "FOLDER" || name.ends_with('/'))
    value.is_folder = true;
  else if (name == "FILE")
    add_once(value.endings, "");
  else if (std::regex_match(name, found, ending_form))
    add_once(value.endings, found[1]);
  else if (std::regex_match(name, word_form))
    add_once(value.words, name);
}

ValueWords value_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t checks = std::min(type.find(':'), type.size());
  ValueWords value;
  value.name = type.substr(0, checks);
  if (value.name == "UINT" || value.name == "INT" || value.name == "FLOAT") value.name = "N";
  value.separator = option.get_delimiter();
  add_members(type.substr(checks), value.words);
  for (const std::string& alternative : split(value.name, '|')) add_alternative(alternative, value);
  return value;
}

OptionWords option_words(const CLI::Option& option) {
  OptionWords words;
  for (const std::string& name : option.get_snames()) words.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) words.names.push_back("--" + name);
  words.about = first_clause(option.get_description());
  words.takes_value = option.get_items_expected_max() > 0;
  words.repeats = words.takes_value && option.get_items_expected_max() > 1;
  if (words.takes_value) words.value = value_of(option);
  return words;
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

CommandWords words_of(const CLI::App& app) {
  CommandWords command;
  command.name = app.get_name();
  command.about = first_clause(app.get_description());
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      command.places.push_back({option->get_items_expected_max() > 1, value_of(*option)});
      if (command.places.back().value.name.empty()) command.places.back().value.name = option->get_name(true);
    } else {
      command.options.push_back(option_words(*option));
    }
  }
  for (const CLI::App* sub_command : app.get_subcommands({})) command.commands.push_back(words_of(*sub_command));
  return command;
}

std::string completion_script(const CLI::App& app, const std::string& shell) {
  const CommandWords program = words_of(app);
  return shell == "bash" ? bash_completion(program) : shell == "zsh" ? zsh_completion(program) : fish_completion(program);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
  return text;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string text;
  for (const std::string& word : words) text += (&word == words.data() ? "" : between) + word;
  return text;
}

std::string function_name(const CommandWords& program) {
  return replaced(program.name, "-", "_");
}

}  // namespace coppice::command_line
