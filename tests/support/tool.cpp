#include "tool.h"

#include <algorithm>
#include <ostream>
#include <thread>

#include <gtest/gtest.h>

namespace coppice::test {

ProcessResult run_tool(const Words& arguments, const ProcessOptions& options) {
  return run_process(kTool, arguments, options);
}

void expect_failure(const ProcessResult& result, const Words& names, int exit_code) {
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  for (const std::string& name : names) EXPECT_TRUE(mentions(result.err, {name}));
}

void expect_error(const ProcessResult& result, const Words& names, const std::string& about) {
  EXPECT_EQ(result.exit_code, 1) << about << "\n" << result.err;
  EXPECT_EQ(result.signal, 0) << about;
  const std::string err = unwrapped(result.err);
  EXPECT_EQ(count_of(err, "\n"), 1u) << about << "\n" << err;
  EXPECT_TRUE(err.starts_with("coppice: ")) << about << "\n" << err;
  for (const std::string& name : names) EXPECT_TRUE(mentions(err, {name})) << about;
}

void expect_one_line_error(const ProcessResult& result, const Words& names, const std::string& about) {
  expect_error(result, names, about);
  EXPECT_EQ(result.out, "") << about;
  EXPECT_EQ(count_of(result.err, "\n"), 1u) << about << "\n" << result.err;
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

nlohmann::json read_json(const std::filesystem::path& path) {
  return nlohmann::json::parse(read_text(path));
}

std::set<std::string> keys_of(const nlohmann::json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.insert(key);
  return keys;
}

BatchCounts counts_in(const std::filesystem::path& report) {
  const nlohmann::json json = read_json(report);
  return {json["baked"], json["cached"], json["failed"]};
}

void PrintTo(const BatchCounts& counts, std::ostream* out) {
  *out << counts.baked << " baked, " << counts.cached << " cached, " << counts.failed << " failed";
}

bool comes_true(const std::function<bool()>& condition, std::chrono::seconds most) {
  const auto start = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - start < most) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

}  // namespace coppice::test
