// The script for zsh: a call of _arguments for the program and for each of its commands.
#include "completion.h"

namespace coppice::command_line {
namespace {

std::string quoted_for_zsh(const std::string& text) {
  return "'" + replaced(text, "'", R"('\'')") + "'";
}

/// Some letters with a backslash before them.
std::string escaped(std::string text, const std::string& letters) {
  for (const char letter : "\\" + letters) text = replaced(std::move(text), std::string(1, letter), std::string("\\") + letter);
  return text;
}

std::string file_call(const ValueWords& value) {
  if (value.endings.empty()) return "_files -/";
  std::vector<std::string> patterns;
  for (const std::string& ending : value.endings) {
    if (ending.empty()) return "_files";
    patterns.push_back("*" + ending);
  }
  return "_files -g \"" + (patterns.size() == 1 ? patterns[0] : "(" + joined(patterns, "|") + ")") + "\"";
}

/// ":IN.glb:_files ...", as _arguments takes it.
std::string value_text(const ValueWords& value) {
  const bool has_files = !value.endings.empty() || value.is_folder;
  std::string words = joined(value.words, " "), action;
  if (has_files && !words.empty())
    action = "{compadd - " + words + "; " + file_call(value) + "}";
  else if (has_files && value.is_named)
    action = "{compset -P \"*=\" && " + file_call(value) + "}";
  else if (has_files)
    action = (value.separator != 0 ? "_sequence " : "") + file_call(value);
  else if (!words.empty())
    action = value.separator != 0 ? "_sequence compadd - " + words : "(" + words + ")";
  else
    action = " ";
  return ":" + escaped(value.name, ":") + ":" + action;
}

/// The arguments of _arguments for an option: one for each of its names, which exclude each other.
std::string option_lines(const OptionWords& option, const std::string& indent) {
  const bool ends_line = option.names.back() == "--help" || option.names.back() == "--version";
  const std::string others = option.repeats ? "*" : ends_line ? "(- *)" : "(" + joined(option.names, " ") + ")";
  const std::string about = "[" + escaped(option.about, "[]") + "]" + (option.takes_value ? value_text(option.value) : "");
  std::string text;
  for (const std::string& name : option.names) {
    std::string argument = others + name;
    argument += !option.takes_value ? "" : name.starts_with("--") ? "=" : "+";
    argument += about;
    text += indent;
    text += quoted_for_zsh(argument);
    text += " \\\n";
  }
  return text;
}

std::string arguments(const CommandWords& command, const std::string& indent) {
  std::string text;
  for (const OptionWords& option : command.options) text += option_lines(option, indent);
  for (std::size_t i = 0; i < command.places.size(); ++i)
    text +=
        indent + quoted_for_zsh((command.places[i].repeats ? "*" : std::to_string(i + 1)) + value_text(command.places[i].value)) + " \\\n";
  return text;
}

/// The rest of the function for a program with sub-commands.
std::string command_texts(const CommandWords& program) {
  std::string names, cases;
  for (const CommandWords& command : program.commands) {
    names += "        " + quoted_for_zsh(escaped(command.name, ":") + ":" + command.about) + "\n";
    cases += "        " + command.name + ")\n          _arguments -S \\\n" + arguments(command, "            ") +
             "            && ret=0\n          ;;\n";
  }
  return "  case $state in\n    command)\n      local -a commands=(\n" + names +
         "      )\n      _describe command commands && ret=0\n      ;;\n    argument)\n      case ${words[1]} in\n" + cases +
         "      esac\n      ;;\n  esac\n";
}

}  // namespace

std::string zsh_completion(const CommandWords& program) {
  const std::string name = function_name(program), indent = "    ";
  const std::string states = program.commands.empty() ? ""
                                                      : indent + quoted_for_zsh("1:command:->command") + " \\\n" + indent +
                                                            quoted_for_zsh("*::argument:->argument") + " \\\n";
  return "#compdef " + program.name + "\n# Completion of " + program.name + " in zsh, made by " + program.name +
         " of what its --help lists.\n\n_" + name +
         "() {\n  local context state state_descr line ret=1\n  typeset -A opt_args\n  _arguments -S -C \\\n" + arguments(program, indent) +
         states + indent + "&& ret=0\n" + (program.commands.empty() ? "" : command_texts(program)) +
         "  return ret\n}\n\n# Of a file on fpath this is the function's body; it may also be sourced.\nif [[ ${funcstack[1]} == _" + name +
         " ]]; then\n  _" + name + " \"$@\"\nelse\n  compdef _" + name + " " + program.name + "\nfi\n";
}

}  // namespace coppice::command_line
