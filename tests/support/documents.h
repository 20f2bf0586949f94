#pragma once

// The repository's Markdown files, as far as tests compare them with the programs.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace coppice::test {

/// The repository's root.
std::filesystem::path source_folder();

/// The text of a file, by its path from the root. Throws std::runtime_error where it cannot be read.
std::string source_text(const std::filesystem::path& path);

/// All Markdown files that are ours, by their paths from the root.
std::vector<std::filesystem::path> documents();

/// The lines of all blocks of code.
std::vector<std::string> code_lines(const std::string& document);

/// The text without its blocks of code.
std::string prose(const std::string& document);

/// What stands between single backticks in text that has no blocks of code.
std::vector<std::string> code_spans(const std::string& text);

/// The cells of a table without its heading. Empty: no table.
using Table = std::vector<std::vector<std::string>>;

/// The first table after a place in the text, which is the place of `heading`. Throws std::runtime_error where there is no such place, or
/// no table after it.
Table table_after(const std::string& document, const std::string& heading);

/// The code spans of all cells of a column.
std::set<std::string> column_spans(const Table& table, std::size_t column);

/// The code spans in the second cell of the row whose first cell has the span `name`: keys below a key. Empty: no such row.
std::set<std::string> spans_of_row(const Table& table, const std::string& name);

}  // namespace coppice::test
