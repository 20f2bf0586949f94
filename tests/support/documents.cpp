#include "documents.h"
#include "places.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>

namespace coppice::test {
namespace {

namespace fs = std::filesystem;

const std::string kFence = "```";

/// The lines inside or outside of blocks of code.
std::vector<std::string> lines_of(const std::string& document, bool in_blocks) {
  std::vector<std::string> lines;
  std::istringstream stream(document);
  bool in_block = false;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with(kFence))
      in_block = !in_block;
    else if (in_block == in_blocks)
      lines.push_back(line);
  }
  return lines;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) {
    const std::size_t begin = std::min(cell.find_first_not_of(' '), cell.size()), end = cell.find_last_not_of(' ');
    cells.push_back(end == std::string::npos ? "" : cell.substr(begin, end + 1 - begin));
  }
  return cells;
}

}  // namespace

fs::path source_folder() {
  return kSourceFolder;
}

std::string source_text(const fs::path& path) {
  std::ifstream file(source_folder() / path);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file || text.empty()) throw std::runtime_error("cannot read " + path.string());
  return text;
}

std::vector<fs::path> documents() {
  std::vector<fs::path> found;
  // Not ours, or made.
  const std::set<fs::path> foreign = {"build", "out", "node_modules", ".git"};
  for (fs::recursive_directory_iterator entry(source_folder()), end; entry != end; ++entry) {
    if (entry->is_directory() && foreign.contains(entry->path().filename())) entry.disable_recursion_pending();
    if (entry->path().extension() == ".md") found.push_back(entry->path().lexically_relative(source_folder()));
  }
  std::ranges::sort(found);
  return found;
}

std::vector<std::string> code_lines(const std::string& document) {
  return lines_of(document, true);
}

std::string prose(const std::string& document) {
  std::string text;
  for (const std::string& line : lines_of(document, false)) text += line + "\n";
  return text;
}

std::vector<std::string> code_spans(const std::string& text) {
  std::vector<std::string> spans;
  for (std::size_t at = text.find('`'); at != std::string::npos; at = text.find('`', at + 1)) {
    const std::size_t end = text.find('`', at + 1);
    if (end == std::string::npos) break;
    spans.push_back(text.substr(at + 1, end - at - 1));
    at = end;
  }
  return spans;
}

Table table_after(const std::string& document, const std::string& heading) {
  const std::size_t place = document.find(heading);
  if (place == std::string::npos) throw std::runtime_error("no place with " + heading);
  std::istringstream stream(document.substr(place));
  Table rows;
  std::string line;
  while (std::getline(stream, line) && !line.starts_with("| ")) {
  }
  std::getline(stream, line);  // the line below the heading
  while (std::getline(stream, line) && line.starts_with("| ")) rows.push_back(cells_of(line));
  if (rows.empty()) throw std::runtime_error("no table after " + heading);
  return rows;
}

std::set<std::string> column_spans(const Table& table, std::size_t column) {
  std::set<std::string> spans;
  for (const auto& row : table)
    for (const std::string& span : code_spans(row.at(column))) spans.insert(span);
  return spans;
}

std::set<std::string> spans_of_row(const Table& table, const std::string& name) {
  for (const auto& row : table) {
    const std::vector<std::string> names = code_spans(row.at(0));
    if (std::ranges::find(names, name) == names.end()) continue;
    const std::vector<std::string> spans = code_spans(row.at(1));
    return {spans.begin(), spans.end()};
  }
  return {};
}

}  // namespace coppice::test
