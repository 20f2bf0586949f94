#pragma once

// Completion of a program's command line. A shell's script asks the program at each Tab what may stand for the word at the cursor:
//   PROGRAM --complete WORDS...    the command line without its first word, up to the cursor; the last word is the one to complete
// The program answers from its CLI11 app, so that it knows what --help lists. Each line is a word, a tab and a description, or one of
// these:
//   :before TAB TEXT    comes first: the word begins with TEXT, which stays; all else is for what follows it
//   :list               further values may follow in the same word
//   :file TAB ENDING    the shell adds files with this ending, all where it is empty
//   :folder             the shell adds folders

#include <array>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace coppice::command_line {

/// Asks for completion. It is no option of the app: --help does not list it.
inline constexpr const char* kCompleteOption = "--complete";

/// The answer to --complete. Values are known from CLI::IsMember and CLI::CheckedTransformer, and from type names, which are alternatives
/// with | between: "F.json" is a file with this ending, "FILE" any file, "FOLDER" and "OUT/" are folders, "NAME=MAP.png" is such a file
/// after a name and =, "A.coppice,..." several, and what is written small is a word as it is: "on|off".
std::string completions(const CLI::App& app, std::vector<std::string> words);

/// A text's first clause: up to a full stop, a semicolon, a colon that follows at least two words, or what is in brackets.
std::string first_clause(const std::string& text);

inline constexpr std::array kShells = {"bash", "zsh", "fish"};

/// The script of a program for one of kShells.
std::string completion_script(const std::string& program, const std::string& shell);

}  // namespace coppice::command_line
