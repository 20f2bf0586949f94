#pragma once

// Scripts with which shells complete a program's command line. They are made of CLI11's app, so that they know what --help lists:
// sub-commands, options, and what may stand behind an option or in a place.

#include <array>
#include <string>
#include <vector>

namespace CLI {
class App;
}  // namespace CLI

namespace coppice::command_line {

/// What a word may be, as far as the program knows. All empty: nobody knows.
struct ValueWords {
  std::string name;                  ///< of its type, for people: "IN.glb|IN.gltf"
  std::vector<std::string> words;    ///< the set that it is of, or words beside files
  std::vector<std::string> endings;  ///< of files: ".glb"; "" is any file
  bool is_folder = false;
  bool is_named = false;  ///< begins with a name and =
  char separator = 0;     ///< between values in one word; 0: it is one value
};

struct OptionWords {
  std::vector<std::string> names;  ///< "-o", "--output"
  std::string about;               ///< one clause
  bool takes_value = false;
  bool repeats = false;
  ValueWords value;
};

/// A positional.
struct PlaceWords {
  bool repeats = false;  ///< it and all after it
  ValueWords value;
};

/// A program, or one of its sub-commands.
struct CommandWords {
  std::string name, about;
  std::vector<OptionWords> options;
  std::vector<PlaceWords> places;
  std::vector<CommandWords> commands;  ///< of a program
};

/// What an app says of itself. Values are known from CLI::IsMember and CLI::CheckedTransformer, and from type names, which are alternatives
/// with | between: "F.json" is a file with this ending, "FILE" any file, "FOLDER" and "OUT/" are folders, "NAME=MAP.png" is such a file
/// after a name and =, "A.coppice,..." several, and what is written small is a word as it is: "on|off".
CommandWords words_of(const CLI::App& app);

/// A text's first clause: up to a full stop, a semicolon, a colon that follows at least two words, or what is in brackets.
std::string first_clause(const std::string& text);

inline constexpr std::array kShells = {"bash", "zsh", "fish"};

std::string bash_completion(const CommandWords& program);
std::string zsh_completion(const CommandWords& program);
std::string fish_completion(const CommandWords& program);

/// The app's script for one of kShells.
std::string completion_script(const CLI::App& app, const std::string& shell);

/// For the scripts: every FROM of a text is TO; words with something between; and a text in single quotes.
std::string replaced(std::string text, const std::string& from, const std::string& to);
std::string joined(const std::vector<std::string>& words, const std::string& between);

/// The name of a program in names of a shell's functions: "coppice_forest".
std::string function_name(const CommandWords& program);

}  // namespace coppice::command_line
