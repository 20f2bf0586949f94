// The script for bash: two tables, one of the words of each command and one of the values that follow options or stand in places, and a
// function that reads them.
#include "completion.h"

namespace coppice::command_line {
namespace {

constexpr const char* kBashHead = R"(# Completion of PROGRAM in bash, made by PROGRAM of what its --help lists.
)";

constexpr const char* kTail = R"(
# What fills the word at the cursor goes to COMPREPLY.
_FUNCTION() {
  local IFS=$' \t\n' line=() word last='' current command='' option='' place=1 only_places='' i
  local options='' commands='' words='' endings=() folders='' separator='' named=''
  # readline ends words at =; here they are whole again.
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    word="${COMP_WORDS[i]}"
    if [[ ${#line[@]} -gt 0 && ($word == '=' || $last == '=') ]]; then
      line[-1]+="$word"
    else
      line+=("$word")
    fi
    last="$word"
  done
  current="${line[-1]}"
  unset 'line[-1]'
  _FUNCTION_words ''
  for word in ${line[@]+"${line[@]}"}; do
    if [[ $option ]]; then
      option=''
    elif [[ $only_places || $word != -* ]]; then
      if [[ $commands && -z $command ]]; then command="$word"; else ((place += 1)); fi
    elif [[ $word == -- ]]; then
      only_places=1
    elif [[ $word != *=* ]] && _FUNCTION_value "$command $word"; then
      option="$word"
    fi
  done

  local before=''
  if [[ -z $option && -z $only_places && $current == --*=* ]]; then
    option="${current%%=*}"
    before="$option="
    current="${current#*=}"
  fi
  if [[ $option ]]; then
    _FUNCTION_value "$command $option" || return 0
  elif [[ -z $only_places && $current == -* ]]; then
    _FUNCTION_words "$command"
    words="$options"
  elif [[ $commands && -z $command ]]; then
    words="$commands"
  else
    _FUNCTION_value "$command $place" || _FUNCTION_value "$command ..." || return 0
  fi

  # What stands before the value stays: a name, and the values before it in a list.
  if [[ $named ]]; then
    [[ $current == *=* ]] || return 0
    before+="${current%%=*}="
    current="${current#*=}"
  fi
  if [[ $separator && $current == *"$separator"* ]]; then
    before+="${current%"$separator"*}$separator"
    current="${current##*"$separator"}"
  fi
  local found=() ending
  if [[ $words ]]; then
    mapfile -t found < <(compgen -W "$words" -- "$current")
  fi
  for ending in ${endings[@]+"${endings[@]}"}; do
    mapfile -t -O "${#found[@]}" found < <(compgen -f -X "!*$ending" -- "$current")
  done
  if [[ $folders ]]; then
    mapfile -t -O "${#found[@]}" found < <(compgen -d -- "$current")
    compopt -o filenames 2>/dev/null
  fi
  if [[ $separator ]]; then
    compopt -o nospace 2>/dev/null
  fi
  # readline replaces what follows the last =.
  if [[ $COMP_WORDBREAKS == *=* ]]; then
    before="${before##*=}"
  fi
  COMPREPLY=()
  for word in ${found[@]+"${found[@]}"}; do
    COMPREPLY+=("$before$word")
  done
}
complete -F _FUNCTION PROGRAM
)";

std::string quoted_for_bash(const std::string& text) {
  return "'" + replaced(text, "'", R"('\'')") + "'";
}

/// The assignments of a value, as a line of the table.
std::string value_line(const std::vector<std::string>& keys, const ValueWords& value) {
  std::string text;
  std::vector<std::string> patterns, endings;
  for (const std::string& key : keys) patterns.push_back(quoted_for_bash(key));
  for (const std::string& ending : value.endings) endings.push_back(quoted_for_bash(ending));
  if (!value.words.empty()) text += " words=" + quoted_for_bash(joined(value.words, " "));
  if (!endings.empty()) text += " endings=(" + joined(endings, " ") + ")";
  if (value.is_folder || !endings.empty()) text += " folders=1";
  if (value.separator != 0) text += " separator=" + quoted_for_bash(std::string(1, value.separator));
  if (value.is_named) text += " named=1";
  return "    " + joined(patterns, " | ") + ")" + text + " ;;\n";
}

std::string value_lines(const CommandWords& command, const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < command.places.size(); ++i)
    text += value_line({name + " " + (command.places[i].repeats ? "..." : std::to_string(i + 1))}, command.places[i].value);
  for (const OptionWords& option : command.options) {
    if (!option.takes_value) continue;
    std::vector<std::string> keys = option.names;
    for (std::string& key : keys) key.insert(0, name + " ");
    text += value_line(keys, option.value);
  }
  return text;
}

std::string words_line(const CommandWords& command, const std::string& name) {
  std::vector<std::string> options, commands;
  for (const OptionWords& option : command.options) options.insert(options.end(), option.names.begin(), option.names.end());
  for (const CommandWords& sub_command : command.commands) commands.push_back(sub_command.name);
  std::string text = "    " + quoted_for_bash(name) + ") options=" + quoted_for_bash(joined(options, " "));
  if (!commands.empty()) text += " commands=" + quoted_for_bash(joined(commands, " "));
  return text + " ;;\n";
}

}  // namespace

std::string bash_completion(const CommandWords& program) {
  std::string words = words_line(program, ""), values = value_lines(program, "");
  for (const CommandWords& command : program.commands) {
    words += words_line(command, command.name);
    values += value_lines(command, command.name);
  }
  const std::string text =
      std::string(kBashHead) +
      "\n# Sets the options of a command, of the program where that is empty.\n"
      "_FUNCTION_words() {\n  case \"$1\" in\n" +
      words +
      "  esac\n}\n"
      "\n# Sets what may follow an option or stand in a place, \"COMMAND OPTION\" or \"COMMAND 1\"; fails where that is nothing.\n"
      "_FUNCTION_value() {\n  words='' endings=() folders='' separator='' named=''\n  case \"$1\" in\n" +
      values + "    *) return 1 ;;\n  esac\n}\n" + kTail;
  return replaced(replaced(text, "FUNCTION", function_name(program)), "PROGRAM", program.name);
}

}  // namespace coppice::command_line
