// The script for fish: a call of complete for each option, and two functions for what fish has none for.
#include "completion.h"

namespace coppice::command_line {
namespace {

constexpr const char* kFishHead = R"(# Completion of PROGRAM in fish, made by PROGRAM of what its --help lists.

# What stands before the value that is being written: --option= goes, names and earlier values of a list stay.
function __FUNCTION_before
    string replace --regex -- '^--[a-z-]+=' '' (commandline --current-token --cut-at-cursor) | string replace --regex -- '[^=,]*$' ''
end

# Words, of which a list may hold several.
function __FUNCTION_words
    set --local before (__FUNCTION_before)
    printf '%s\n' $before$argv
end

# Folders, and files with these endings, "" for any.
function __FUNCTION_files
    set --local before (__FUNCTION_before)
    set --local token (string replace --regex -- '^--[a-z-]+=' '' (commandline --current-token --cut-at-cursor))
    set --local endings (string join '|' -- (string escape --style=regex -- / $argv))
    set --local files (complete --do-complete "__fish_command_without_completions "(string replace -- $before '' $token))
    printf '%s\n' $before(string match --regex -- "^[^\t]*(?:$endings)\$" (string replace --regex -- '\t.*' '' $files))
end

complete --command PROGRAM --no-files
)";

std::string quoted_for_fish(const std::string& text) {
  return "'" + replaced(replaced(text, R"(\)", R"(\\)"), "'", R"(\')") + "'";
}

/// What --arguments takes; empty where nothing is known.
std::string arguments_of(const ValueWords& value) {
  std::string text =
      value.separator != 0 && !value.words.empty() ? "(__FUNCTION_words " + joined(value.words, " ") + ")" : joined(value.words, " ");
  if (value.endings.empty() && !value.is_folder) return text;
  std::string endings;
  for (const std::string& ending : value.endings) endings += ending.empty() ? " \"\"" : " " + ending;
  return text + (text.empty() ? "" : " ") + "(__FUNCTION_files" + endings + ")";
}

std::string option_line(const OptionWords& option, const std::string& begin) {
  std::string text;
  // fish has one description for all names of an option, and cannot tell --taa and --no-taa apart from -h and --help.
  for (const std::string& name : option.names)
    text += name.starts_with("--") ? " --long-option " + name.substr(2) : " --short-option " + name.substr(1);
  if (option.takes_value) text += " --exclusive";
  const std::string arguments = option.takes_value ? arguments_of(option.value) : "";
  if (!arguments.empty()) text += " --arguments " + quoted_for_fish(arguments);
  return begin + text + " --description " + quoted_for_fish(option.about) + "\n";
}

std::string lines(const CommandWords& command, const std::string& begin) {
  std::string text;
  for (const OptionWords& option : command.options) text += option_line(option, begin);
  for (const PlaceWords& place : command.places)
    if (const std::string arguments = arguments_of(place.value); !arguments.empty())
      text += begin + " --arguments " + quoted_for_fish(arguments) + "\n";
  return text;
}

}  // namespace

std::string fish_completion(const CommandWords& program) {
  const std::string begin = "complete --command " + program.name;
  std::string text = kFishHead + lines(program, begin + (program.commands.empty() ? "" : " --condition __fish_use_subcommand"));
  for (const CommandWords& command : program.commands) {
    text += "\n" + begin + " --condition __fish_use_subcommand --arguments " + command.name + " --description " +
            quoted_for_fish(command.about) + "\n";
    text += lines(command, begin + " --condition " + quoted_for_fish("__fish_seen_subcommand_from " + command.name));
  }
  return replaced(replaced(text, "FUNCTION", function_name(program)), "PROGRAM", program.name);
}

}  // namespace coppice::command_line
