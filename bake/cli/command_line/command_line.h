#pragma once

// Help and usage errors that a person reads: lines that fit a terminal, ranges in words, and of a slip of the keyboard what was meant.

#include <memory>
#include <string>
#include <vector>

namespace CLI {
class App;
class FormatterBase;
}  // namespace CLI

namespace coppice::command_line {

/// No line of a help text is longer, unless a word is.
inline constexpr std::size_t kColumns = 100;

/// Breaks lines at spaces. What follows a break is as far in as the line it is of.
std::string wrapped(const std::string& text, std::size_t columns = kColumns);

/// Sets how an app prints its help, before it gets sub-commands: at most kColumns, and "from 1 to 9" for CLI11's "INT in [1 - 9]".
std::shared_ptr<CLI::FormatterBase> help_format();

/// Which of the words was probably meant: the nearest, where at most a third of its letters have to be changed, added, left out or swapped
/// with their neighbour. Empty: none.
std::string meant(const std::string& word, const std::vector<std::string>& words);

/// What is wrong with the first word that is no sub-command of the app, or the first option that is none of the app's or its sub-command's,
/// and what was meant; empty where all are known. What follows "--" is nobody's option.
/// arguments  without the program's name
std::string unknown_word(const CLI::App& app, const std::vector<std::string>& arguments);

}  // namespace coppice::command_line
