// The scripts for shells: completion.h says what they ask the program and what it answers. They call the program as the user does.
#include <regex>

#include "completion.h"

namespace coppice::command_line {
namespace {

constexpr const char* kBash = R"(# Completion of PROGRAM in bash: the program is asked what may stand for the word at the cursor.
_FUNCTION() {
  local words=() last='' word kind text current before='' found=()
  # readline ends words at =; here they are whole again.
  for word in "${COMP_WORDS[@]:1:COMP_CWORD}"; do
    if [[ ${#words[@]} -gt 0 && ($word == '=' || $last == '=') ]]; then words[-1]+="$word"; else words+=("$word"); fi
    last="$word"
  done
  current="${words[-1]}"
  while IFS=$'\t' read -r kind text; do
    case "$kind" in
      :before) before="$text" current="${current:${#text}}" ;;
      :list) compopt -o nospace 2>/dev/null ;;
      :file) mapfile -t -O "${#found[@]}" found < <(compgen -f -X "!*$text" -- "$current") ;;
      :folder) compopt -o filenames 2>/dev/null; mapfile -t -O "${#found[@]}" found < <(compgen -d -- "$current") ;;
      "$current"*) found+=("$kind") ;;
    esac
  done < <("${COMP_WORDS[0]/#\~/$HOME}" --complete "${words[@]}" 2>/dev/null)
  if [[ $COMP_WORDBREAKS == *=* ]]; then before="${before##*=}"; fi # readline replaces what follows the last =
  COMPREPLY=()
  for word in ${found[@]+"${found[@]}"}; do COMPREPLY+=("$before$word"); done
}
complete -F _FUNCTION PROGRAM
)";

constexpr const char* kZsh = R"zsh(#compdef PROGRAM
# Completion of PROGRAM in zsh: the program is asked what may stand for the word at the cursor.
_FUNCTION() {
  local line kind text ret=1
  local -a lines values patterns files suffix
  lines=("${(@f)$("${words[1]/#\~/$HOME}" --complete "${(@Q)words[2,CURRENT-1]}" "${(Q)PREFIX}" 2>/dev/null)}")
  for line in $lines; do
    kind="${line%%$'\t'*}" text="${line#*$'\t'}"
    case $kind in
      :before) compset -P "${(b)text}" ;;
      :list) suffix=(-S '') ;;
      :file) patterns+=("*$text") ;;
      :folder) files=(-/) ;;
      *) values+=("${kind//:/\\:}${text:+:$text}") ;;
    esac
  done
  if (($#values)); then _describe value values "${suffix[@]}" && ret=0; fi
  # Parentheses without | would be qualifiers of the pattern.
  if (($#patterns)); then files=(-g "(${(j:|:)patterns}|)"); fi
  if (($#files)); then _files "${suffix[@]}" $files && ret=0; fi
  return ret
}
# On fpath this file is the function's body; it may also be sourced.
if [[ ${funcstack[1]} == _PROGRAM ]]; then _FUNCTION "$@"; else compdef _FUNCTION PROGRAM; fi
)zsh";

constexpr const char* kFish = R"(# Completion of PROGRAM in fish: the program is asked what may stand for the word at the cursor.
function __FUNCTION_complete
    set --local words (commandline --tokenize --current-process --cut-at-cursor)
    set --local current (commandline --current-token --cut-at-cursor)
    set --local before ''
    set --local endings
    for line in (command $words[1] --complete $words[2..] "$current" 2>/dev/null)
        set --local parts (string split --max 1 \t -- $line)
        switch $parts[1]
            case :before
                set before $parts[2]
            case :list
            case :file
                set --append endings (string escape --style=regex -- $parts[2])
            case :folder
                set --append endings /
            case '*'
                printf '%s\n' $before$line
        end
    end
    set --query endings[1]; or return
    set --local files (complete --do-complete "__fish_command_without_completions "(string replace -- $before '' "$current"))
    for file in (string match --regex -- '^[^\t]*(?:'(string join '|' -- $endings)')$' (string replace --regex -- '\t.*' '' $files))
        printf '%s\n' $before$file
    end
end
complete --command PROGRAM --no-files --arguments '(__FUNCTION_complete)'
)";

}  // namespace

std::string completion_script(const std::string& program, const std::string& shell) {
  static const std::regex dash("-"), function("FUNCTION"), name("PROGRAM");
  const std::string text = shell == "bash" ? kBash : shell == "zsh" ? kZsh : kFish;
  return std::regex_replace(std::regex_replace(text, function, std::regex_replace(program, dash, "_")), name, program);
}

}  // namespace coppice::command_line
