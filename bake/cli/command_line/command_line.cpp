#include "command_line.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <numeric>
#include <regex>
#include <set>

#include <CLI/CLI.hpp>

namespace coppice::command_line {
namespace {

/// "1e-09" -> "0.000000001", "16" -> "16"
std::string plain_number(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || text.find('e') == std::string::npos) return text;
  char digits[400];  // the largest double has 309
  std::snprintf(digits, sizeof digits, "%.12f", value);
  std::string plain = digits;
  plain.erase(plain.find_last_not_of('0') + 1);
  if (plain.back() == '.') plain.pop_back();
  return plain;
}

/// CLI11 has a type and what its values are checked for in one text: "PX:UINT in [16 - 2048]".
std::string type_of(const CLI::Option& option) {
  const std::string type = option.get_type_name(), name = type.substr(0, type.find(':'));
  return name == "UINT" || name == "INT" || name == "FLOAT" ? "N" : name;
}

std::string range_of(const CLI::Option& option) {
  static const std::regex range_form(R"((?:INT|FLOAT) in \[([^ ]+) - ([^\]]+)\])");
  const std::string type = option.get_type_name();
  std::smatch found;
  if (!std::regex_search(type, found, range_form)) return "";
  return "from " + plain_number(found[1]) + " to " + plain_number(found[2]);
}

std::string names_of(const std::set<CLI::Option*>& options) {
  std::set<std::string> names;  // pointers are in another order in every run
  for (const CLI::Option* option : options) names.insert(option->get_name());
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

class HelpFormat : public CLI::Formatter {
 public:
  [[nodiscard]] std::string make_option(const CLI::Option* option, bool is_positional) const override {
    return entry(make_option_name(option, is_positional) + make_option_opts(option), make_option_desc(option));
  }
  [[nodiscard]] std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    // A flag that switches something off has its value behind its name: "--no-shadows{false}".
    static const std::regex value_form(R"(\{[^}]*\})"), comma_form(",-");
    const std::string names = std::regex_replace(CLI::Formatter::make_option_name(option, is_positional), value_form, "");
    return std::regex_replace(names, comma_form, ", -");
  }
  [[nodiscard]] std::string make_option_opts(const CLI::Option* option) const override {
    const std::string type = option->get_type_size() != 0 ? type_of(*option) : "";
    return (type.empty() ? "" : " " + type) + (option->get_required() ? " (required)" : "");
  }
  [[nodiscard]] std::string make_option_desc(const CLI::Option* option) const override {
    std::string text = option->get_description();
    if (const std::string range = range_of(*option); !range.empty()) text += "; " + range;
    if (!option->get_needs().empty()) text += "; needs " + names_of(option->get_needs());
    if (!option->get_excludes().empty()) text += "; not with " + names_of(option->get_excludes());
    if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + "]";
    return text;
  }
  [[nodiscard]] std::string make_subcommand(const CLI::App* command) const override {
    return entry(command->get_name(), command->get_description());
  }
  [[nodiscard]] std::string make_description(const CLI::App* app) const override { return wrapped(app->get_description()) + "\n"; }
  [[nodiscard]] std::string make_footer(const CLI::App* app) const override {
    return app->get_footer().empty() ? "" : wrapped(app->get_footer()) + "\n";
  }

 private:
  static std::string entry(const std::string& name, const std::string& description) {
    constexpr std::size_t kNameColumns = 34;
    const std::string left = "  " + name, indent(kNameColumns, ' ');
    std::string text = left + (left.size() < kNameColumns ? std::string(kNameColumns - left.size(), ' ') : "\n" + indent);
    for (const char letter : wrapped(description, kColumns - kNameColumns)) text += letter == '\n' ? "\n" + indent : std::string(1, letter);
    return text + "\n";
  }
};

/// Letters that have to be changed, added, left out or swapped with their neighbour.
std::size_t slips(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    before = last;
    last = row;
  }
  return last[b.size()];
}

std::string unknown(const std::string& where, const std::string& kind, const std::string& word, const std::vector<std::string>& words) {
  const std::string other = meant(word, words);
  return where + ": no " + kind + " " + word + (other.empty() ? "" : ": did you mean " + other + "?");
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
  return names;
}

}  // namespace

std::string wrapped(const std::string& text, std::size_t columns) {
  std::string result;
  for (std::size_t at = 0; at <= text.size();) {
    std::string line = text.substr(at, text.find('\n', at) - at);
    at += line.size() + 1;
    const std::string indent(std::min(line.find_first_not_of(' '), line.size()), ' ');
    while (line.size() > columns) {
      std::size_t space = line.rfind(' ', columns);
      if (space == std::string::npos || space < indent.size()) space = line.find(' ', columns);
      if (space == std::string::npos) break;
      result.append(line, 0, space) += '\n';
      line.replace(0, space + 1, indent);
    }
    result += line + (at <= text.size() ? "\n" : "");
  }
  return result;
}

std::shared_ptr<CLI::FormatterBase> help_format() {
  return std::make_shared<HelpFormat>();
}

std::string meant(const std::string& word, const std::vector<std::string>& words) {
  std::string nearest;
  std::size_t fewest = std::max(std::size_t{1}, word.size() / 3) + 1;
  for (const std::string& candidate : words)
    if (const std::size_t count = slips(word, candidate); count < fewest) {
      fewest = count;
      nearest = candidate;
    }
  return nearest;
}

std::string unknown_word(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* command = &app;
  std::string where = app.get_name();
  const std::vector<std::string> commands = command_names(app);
  for (const std::string& argument : arguments) {
    if (argument == "--") break;
    if (argument.rfind("--", 0) == 0) {
      const std::string name = argument.substr(0, argument.find('='));
      if (command->get_option_no_throw(name) == nullptr) return unknown(where, "option", name, option_names(*command));
    } else if (command == &app && !commands.empty() && argument.rfind('-', 0) != 0) {
      if (std::ranges::find(commands, argument) == commands.end()) return unknown(where, "command", argument, commands);
      command = app.get_subcommand(argument);
      where += " " + argument;
    }
  }
  return "";
}

}  // namespace coppice::command_line
