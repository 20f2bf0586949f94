#include "made_once.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>

#include "places.h"
#include "process.h"

namespace coppice::test {
namespace fs = std::filesystem;
namespace {

bool newer_than_program(const fs::path& file) {
  std::error_code missing;
  const auto written = fs::last_write_time(file, missing);
  return !missing && written > fs::last_write_time(kTool);
}

}  // namespace

fs::path made_once(const std::string& name, const std::function<void(const fs::path& folder)>& make) {
  const fs::path folder = fs::path(kOutputFolder) / "made_once" / name, whole = folder / "is_whole";
  fs::create_directories(folder.parent_path());
  // Another process may be making it. The lock goes with the descriptor.
  const int lock = ::open((folder.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock < 0 || ::flock(lock, LOCK_EX) != 0) throw std::runtime_error("cannot lock " + folder.string());
  try {
    if (!newer_than_program(whole)) {
      fs::remove_all(folder);
      fs::create_directory(folder);
      make(folder);
      std::ofstream{whole};
    }
  } catch (...) {
    ::close(lock);
    throw;
  }
  ::close(lock);
  return folder;
}

fs::path corylus_glb() {
  return made_once("corylus",
                   [](const fs::path& folder) {
                     const ProcessResult grown = run_process(kTool, {"plant", "corylus", "-o", folder / "corylus.glb"});
                     if (grown.exit_code != 0) throw std::runtime_error("coppice plant: " + grown.err);
                   }) /
         "corylus.glb";
}

}  // namespace coppice::test
