// choose_tiers FOLDER DEEP_CASES KEEP SECONDS: the list of deep cases, from what tests/tiers/run recorded in FOLDER.
// Quick are: cases of half a second or less; those that KEEP names; then those that cover most new lines of the product for their
// time, until nothing is new or the quick tier takes SECONDS of one core. Lines of DEEP_CASES whose program was not measured stay as they
// are. FOLDER/cases.txt gets a line for each case: tier, seconds, lines, lines that it alone covers, program, case.
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <queue>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <vector>

namespace {

using Line = std::uint32_t;  // a number of a line of source

struct Case {
  std::string program, name;
  double seconds;
  std::vector<Line> lines;  // ascending
  bool quick;
};

constexpr double kCheapSeconds = 0.5;

// The line of each place of a module, as llvm-symbolizer names it: "FILE:LINE:COLUMN".
std::vector<Line> lines_of_places(const std::filesystem::path& places, std::unordered_map<std::string, Line>& numbers) {
  std::ifstream in(places);
  std::string module;
  std::getline(in, module);
  const std::filesystem::path answers = std::filesystem::path(places).replace_extension("lines");
  if (!exists(answers)) {
    const std::string command = "tail -n +2 '" + places.string() + "' | llvm-symbolizer --obj='" + module +
                                "' --functions=none --no-inlines | grep . >'" + answers.string() + "'";
    // NOLINTNEXTLINE(cert-env33-c): a tool of developers, whose files have no quotes in their names
    if (std::system(command.c_str()) != 0) throw std::runtime_error("llvm-symbolizer: " + places.string());
  }
  std::vector<Line> lines;
  std::ifstream read(answers);
  for (std::string answer; std::getline(read, answer);) {
    const std::string line = answer.substr(0, answer.rfind(':'));  // without the column
    lines.push_back(numbers.try_emplace(line, static_cast<Line>(numbers.size())).first->second);
  }
  return lines;
}

void read_program(const std::filesystem::path& folder, std::unordered_map<std::string, Line>& numbers, std::vector<Case>& cases) {
  std::map<std::string, std::vector<Line>> modules;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".places") modules[entry.path().stem()] = lines_of_places(entry.path(), numbers);
  std::ifstream in(folder / "cases");
  for (std::string text; std::getline(in, text);) {
    std::istringstream words(text);
    Case& one = cases.emplace_back();
    one.program = folder.filename();
    words >> one.name >> one.seconds;
    for (std::string word; words >> word;) {
      const std::size_t colon = word.rfind(':');
      // A program that a test killed, or let run out of memory, may have ended in the middle of a word.
      const auto module = modules.find(word.substr(0, colon));
      if (colon == std::string::npos || module == modules.end()) continue;
      const std::size_t place = std::strtoull(word.c_str() + colon + 1, nullptr, 10);
      if (place < module->second.size()) one.lines.push_back(module->second[place]);
    }
    std::ranges::sort(one.lines);
    one.lines.erase(std::unique(one.lines.begin(), one.lines.end()), one.lines.end());
  }
}

// Cases that guard a promise: programs and patterns.
std::vector<std::pair<std::string, std::string>> read_keep(const char* path) {
  std::vector<std::pair<std::string, std::string>> keep;
  std::ifstream in(path);
  if (!in) throw std::runtime_error(std::string("cannot read ") + path);
  for (std::string text; std::getline(in, text);) {
    std::istringstream words(text);
    std::string program, pattern;
    if (text.starts_with('#') || !(words >> program >> pattern)) continue;
    keep.emplace_back(program, pattern);
  }
  return keep;
}

int run(char** arguments) {
  const std::filesystem::path folder = arguments[1];
  const auto keep = read_keep(arguments[3]);
  const double max_seconds = std::stod(arguments[4]);
  std::unordered_map<std::string, Line> numbers;
  std::vector<Case> cases;
  std::set<std::string> measured;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!exists(entry.path() / "cases")) continue;
    measured.insert(entry.path().filename());
    read_program(entry.path(), numbers, cases);
  }

  std::vector<int> times_covered(numbers.size());
  std::vector<bool> covered(numbers.size());
  double quick_seconds = 0;
  auto make_quick = [&](Case& one) {
    one.quick = true;
    quick_seconds += one.seconds;
    for (const Line line : one.lines) covered[line] = true;
  };
  for (Case& one : cases) {
    for (const Line line : one.lines) ++times_covered[line];
    const bool kept = std::ranges::any_of(
        keep, [&](const auto& k) { return k.first == one.program && fnmatch(k.second.c_str(), one.name.c_str(), 0) == 0; });
    if (kept || one.seconds <= kCheapSeconds) make_quick(one);
  }
  const double given_seconds = quick_seconds;

  // What a case adds never grows as others are taken: the best of the queue, looked at anew, is taken if it is still the best.
  auto new_lines_a_second = [&](const Case& one) {
    const auto added = std::ranges::count_if(one.lines, [&](Line line) { return !covered[line]; });
    return static_cast<double>(added) / std::max(one.seconds, 0.01);
  };
  std::priority_queue<std::pair<double, std::size_t>> queue;
  for (std::size_t i = 0; i < cases.size(); ++i)
    if (!cases[i].quick) queue.emplace(new_lines_a_second(cases[i]), i);
  while (!queue.empty()) {
    Case& one = cases[queue.top().second];
    const double now = new_lines_a_second(one);
    const std::size_t index = queue.top().second;
    queue.pop();
    if (now == 0 || quick_seconds + one.seconds > max_seconds) continue;
    if (!queue.empty() && now < queue.top().first) {
      queue.emplace(now, index);
    } else {
      make_quick(one);
    }
  }

  std::ofstream table(folder / "cases.txt");
  double deep_seconds = 0;
  for (const Case& one : cases) {
    const auto alone = std::ranges::count_if(one.lines, [&](Line line) { return times_covered[line] == 1; });
    table << (one.quick ? "quick " : "deep ") << one.seconds << ' ' << one.lines.size() << ' ' << alone << ' ' << one.program << ' '
          << one.name << '\n';
    if (!one.quick) deep_seconds += one.seconds;
  }
  const auto lines_covered = std::ranges::count(covered, true);
  const auto lines_of_all = std::ranges::count_if(times_covered, [](int times) { return times > 0; });
  std::cerr << cases.size() << " cases measured: quick " << quick_seconds << " s (" << given_seconds << " s of them cheap or kept), deep "
            << deep_seconds << " s; the quick ones cover " << lines_covered << " of " << lines_of_all << " lines\n";

  std::ifstream before(arguments[2]);
  for (std::string text; std::getline(before, text);)
    if (!measured.contains(text.substr(0, text.find(' ')))) std::cout << text << '\n';
  for (const Case& one : cases)
    if (!one.quick) std::cout << one.program << ' ' << one.name << ' ' << std::max(1L, std::lround(one.seconds)) << '\n';
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 5) {
    std::cerr << "choose_tiers FOLDER DEEP_CASES KEEP SECONDS\n";
    return 2;
  }
  try {
    return run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "choose_tiers: " << error.what() << '\n';
    return 1;
  }
}
