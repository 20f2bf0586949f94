#pragma once

// Pages in headless Chromium. A probe is appended to a copy of a page; it waits until the page is drawn, uses its controls and writes what
// it finds as JSON into <pre id="probe">, which Chromium prints.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.h"

namespace coppice::test {

enum class Scheme { dark, light };  // Blink's numbers

/// Chromium's clock jumps from timer to timer, while pictures are decoded in real time: this is 10,000 rounds of the probe's waiting. On a
/// busy machine they can be too few, so a page that was not drawn in time is given more, kAttempts times.
inline constexpr int kVirtualMilliseconds = 200'000;
inline constexpr int kAttempts = 4;

struct Visit {
  std::string document;  ///< the DOM at the end
  std::string console;   ///< log lines of the page's console
};

inline Visit visit(const std::filesystem::path& page, const std::filesystem::path& profile, int width_px, Scheme scheme,
                   int virtual_milliseconds = kVirtualMilliseconds) {
  const ProcessResult result =
      run_process(program_on_path("chromium"),
                  {"--headless", "--no-sandbox", "--disable-gpu", "--user-data-dir=" + profile.string(),
                   "--window-size=" + std::to_string(width_px) + ",900",
                   "--blink-settings=preferredColorScheme=" + std::to_string(static_cast<int>(scheme)), "--enable-logging=stderr",
                   "--virtual-time-budget=" + std::to_string(virtual_milliseconds), "--dump-dom", "file://" + page.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  Visit visit{result.out, {}};
  std::istringstream log(result.err);
  for (std::string line; std::getline(log, line);)
    if (line.find("CONSOLE") != std::string::npos) visit.console += line + "\n";
  return visit;
}

/// Null when the probe has not come to its end.
inline nlohmann::json probe_result(const Visit& visit) {
  const std::string start = "<pre id=\"probe\">";
  const std::size_t at = visit.document.find(start);
  if (at == std::string::npos) return nullptr;
  const std::size_t from = at + start.size();
  return nlohmann::json::parse(visit.document.substr(from, visit.document.find("</pre>", from) - from), nullptr, false);
}

/// Writes the page with `addition` at the end of its body to `path`, which it returns.
inline std::filesystem::path page_with(const std::string& page, const std::string& addition, const std::filesystem::path& path) {
  const std::size_t at = page.rfind("</body>");
  EXPECT_NE(at, std::string::npos);
  std::ofstream(path, std::ios::binary) << page.substr(0, at) << addition << page.substr(at);
  return path;
}

/// What the probe at the end of a page has found. Anything on the console fails.
inline nlohmann::json probed_page(const std::filesystem::path& page, const std::filesystem::path& profile, int width_px, Scheme scheme) {
  nlohmann::json found;
  for (int attempt = 0, milliseconds = kVirtualMilliseconds; attempt < kAttempts && !found.is_object(); ++attempt, milliseconds *= 4) {
    const Visit seen = visit(page, profile, width_px, scheme, milliseconds);
    EXPECT_EQ(seen.console, "");
    found = probe_result(seen);
  }
  EXPECT_TRUE(found.is_object()) << "the page was never drawn";
  return found;
}

}  // namespace coppice::test
