#include "doctor.h"

#include <coppice/coppice.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "child_process.h"
#include "failure.h"
#include "output.h"
#include "picture.h"
#include "trial.h"

namespace forest {
namespace {

/// How a trial went.
struct Finding {
  std::string name;
  std::string verdict;  ///< ok, slow, wrong, hangs, fails
  double ready_ms = 0;  ///< until there was a first picture; 0: there was none
  double frame_ms = 0;  ///< 0: not measured
  std::string note;     ///< what differs, or went wrong
  std::vector<std::string> said;
};

bool is_good(const Finding& finding) {
  return finding.verdict == "ok" || finding.verdict == "slow";
}

/// What of the driver's many lines says why: the first of ours, or the last.
std::string reason_in(const std::string& err) {
  constexpr std::string_view kOurs = "coppice-forest: ";
  std::istringstream lines(err);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kOurs)) return line.substr(kOurs.size());
    if (!line.empty()) last = line;
  }
  return last;
}

/// trial.h says what a trial prints.
void read_lines(const std::string& out, Finding& finding, std::string& step) {
  std::istringstream lines(out);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("at ")) step = line.substr(3);
    if (line.starts_with("say ")) finding.said.push_back(line.substr(4));
    if (!line.starts_with("result ")) continue;
    std::istringstream words(line.substr(7));
    words >> finding.verdict >> finding.ready_ms >> finding.frame_ms >> std::ws;
    std::getline(words, finding.note);
  }
}

void judge(const ChildEnd& end, double limit_s, Finding& finding) {
  std::string step;
  read_lines(end.out, finding, step);
  const std::string after = step.empty() ? "" : ", " + step;
  if (!end.in_time) {
    finding.verdict = "hangs";
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "not done in %g s (--doctor-limit-s)", limit_s);
    finding.note = text.data() + after;
  } else if (end.exit_code != 0) {
    const std::string reason = reason_in(end.err);
    finding.verdict = "fails";
    finding.note = end.signal != 0 ? "ended by signal " + std::to_string(end.signal) + " (" + ::strsignal(end.signal) + ")" + after
                                   : (reason.empty() ? "exit code " + std::to_string(end.exit_code) + after : reason);
  } else if (finding.verdict.empty()) {
    finding.verdict = "fails";
    finding.note = "ended without a result" + after;
  }
}

std::string line_of(const Finding& finding) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "%-12s%-6s", finding.name.c_str(), finding.verdict.c_str());
  std::string line = text.data();
  if (finding.ready_ms > 0) {
    std::snprintf(text.data(), text.size(), "  ready after %.2f s", 0.001 * finding.ready_ms);
    line += text.data();
  }
  if (finding.frame_ms > 0) {
    std::snprintf(text.data(), text.size(), ", %.2f ms a frame", finding.frame_ms);
    line += text.data();
  }
  return finding.note.empty() ? line : line + "  " + finding.note;
}

/// On a terminal, a line that counts seconds, until the finding takes its place.
struct Progress {
  std::string name;
  bool shown = ::isatty(STDOUT_FILENO) == 1;

  void operator()(double seconds) const {
    if (!shown) return;
    std::printf("\r%-12s... %.0f s ", name.c_str(), seconds);
    std::fflush(stdout);
  }
  void finish(const Finding& finding) const {
    std::printf("%s%s\n", shown ? "\r\033[K" : "", line_of(finding).c_str());
    std::fflush(stdout);
  }
};

Finding find(const std::string& name, double limit_s) {
  const Progress progress{name};
  Finding finding;
  finding.name = name;
  judge(run_self({kTrialOption, name, std::to_string(limit_s)}, limit_s, progress), limit_s, finding);
  for (const std::string& line : finding.said) std::printf("%s%s\n", progress.shown ? "\r\033[K" : "", line.c_str());
  if (!finding.said.empty()) std::printf("\n");
  progress.finish(finding);
  return finding;
}

/// Removed with what is in it.
struct Folder {
  std::filesystem::path path;
  Folder() {
    std::string name = std::filesystem::temp_directory_path() / "coppice-doctor-XXXXXX";
    if (!::mkdtemp(name.data())) throw Failure("cannot make the folder " + name + ": " + std::strerror(errno));
    path = name;
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

/// This program as everybody starts it: light, shadow maps, antialiasing. There is no picture to compare its own with.
Finding find_forest(double limit_s) {
  const Progress progress{"forest"};
  const Folder folder;
  const std::string plant = folder.path / "hazel.coppice", figures = folder.path / "figures.json";
  write_output(plant, {static_cast<const char*>(hazel().data), hazel().size});
  Finding finding;
  finding.name = progress.name;
  const std::string wait_s = std::to_string(2 * limit_s);
  const ChildEnd end = run_self(
      {"--plants", plant, "--count", "100", "--headless", "--size", "320x180", "--frames", "5", "--stats", figures, "--gpu-wait-s", wait_s},
      limit_s, progress);
  judge(end, limit_s, finding);
  if (end.in_time && end.exit_code == 0) {
    std::ifstream file(figures);
    const nlohmann::json json = nlohmann::json::parse(file);
    const std::uint32_t visible = json["visible_instances_median"];
    finding.ready_ms = json["first_picture_ms"];
    finding.frame_ms = json["frame_ms"]["median"];
    finding.verdict = visible == 0 ? "wrong" : is_slow(finding.ready_ms, finding.frame_ms, json["software_device"]) ? "slow" : "ok";
    finding.note = std::to_string(visible) + " plants in view; its picture is not compared";
  }
  progress.finish(finding);
  return finding;
}

std::vector<Finding> find_all(double limit_s) {
  std::vector<Finding> findings;
  for (const char* trial : kTrials) {
    findings.push_back(find(trial, limit_s));
    if (findings.size() == 1 && !is_good(findings.front())) return findings;  // nothing else can go better
  }
  findings.push_back(find_forest(limit_s));
  return findings;
}

const Finding* named(const std::vector<Finding>& findings, const char* name) {
  const auto found = std::ranges::find(findings, name, &Finding::name);
  return found == findings.end() ? nullptr : &*found;
}

const char* advice_for(const std::vector<Finding>& findings) {
  if (std::ranges::all_of(findings, is_good)) return "This machine can run Coppice.";
  const Finding* hardware = named(findings, "hardware");
  const bool compute_alone = hardware && is_good(*hardware) && std::ranges::all_of(findings, [](const Finding& finding) {
                               return is_good(finding) || finding.name == "leaves" || finding.name == "splats" ||
                                      finding.name == "surfaces" || finding.name == "shadow_map" || finding.name == "forest";
                             });
  if (compute_alone)
    return "This machine cannot run Coppice as it should. Without the compute rasteriser it may: coppice-forest --path hardware, or in an "
           "engine coppice_vulkan_desc.compute_raster = VK_FALSE.";
  return "This machine cannot run Coppice.";
}

/// Variables that choose drivers and layers, or change them.
std::string vulkan_variables() {
  std::string text;
  for (char** variable = environ; *variable; ++variable)
    for (const char* start : {"VK_", "MESA_", "LP_", "LVP_", "DISABLE_LAYER"})
      if (std::strncmp(*variable, start, std::strlen(start)) == 0) text += std::string(" ") + *variable;
  return text.empty() ? " none" : text;
}

void print_report(const std::vector<Finding>& findings, const char* version) {
  utsname system{};
  ::uname(&system);
  const std::uint32_t library = coppice_version();
  std::printf("\n---- copy from here into a bug report ----\n");
  std::printf("coppice-forest %s, libcoppice %u.%u.%u\n", version, library >> 22, library >> 12 & 0x3ff, library & 0xfff);
  std::printf("system: %s %s %s, %u processors\n", system.sysname, system.release, system.machine, std::thread::hardware_concurrency());
  std::printf("variables:%s\n", vulkan_variables().c_str());
  const std::vector<std::string>& machine = findings.front().said;
  std::printf("device: %s\n", machine.empty() ? "none" : machine.front().c_str());
  std::string missing;
  for (std::size_t i = 1; i < machine.size(); ++i)
    if (!machine[i].ends_with(": yes")) missing += machine[i] + "\n";
  if (!machine.empty()) std::printf("missing:%s\n%s", missing.empty() ? " nothing" : "", missing.c_str());
  for (const Finding& finding : findings) std::printf("%s\n", line_of(finding).c_str());
  std::printf("---- to here ----\n");
}

}  // namespace

int run_doctor(double limit_s, const char* version) {
  const std::vector<Finding> findings = find_all(limit_s);
  std::printf("\n%s\n", advice_for(findings));
  print_report(findings, version);
  return std::ranges::all_of(findings, is_good) ? 0 : 1;
}

}  // namespace forest
