// Writes what each case ran, itself and in the programs that it started: a line "CASE SECONDS MODULE:INDEX ..." in the file `cases`.
// The first case of a suite has what the suite made for all.
#include "coverage_flags.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

namespace coppice::test {
namespace {

std::string take_coverage_of_children() {
  std::string text;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(coverage_folder()))
    if (entry.path().stem() == "process") files.push_back(entry.path());
  for (const std::filesystem::path& file : files) {
    std::string ran;
    std::getline(std::ifstream(file), ran);
    text += ran;
    remove(file);
  }
  return text;
}

class WriteCases : public testing::EmptyTestEventListener {
  void OnTestEnd(const testing::TestInfo& test) override {
    if (coverage_folder().empty()) return;
    std::ofstream(coverage_folder() / "cases", std::ios::app)
        << test.test_suite_name() << '.' << test.name() << ' ' << static_cast<double>(test.result()->elapsed_time()) / 1000 << ' '
        << take_coverage() << take_coverage_of_children() << '\n';
  }
};

const bool listens = [] {
  testing::UnitTest::GetInstance()->listeners().Append(new WriteCases);
  return true;
}();

}  // namespace
}  // namespace coppice::test
