#include "sibling_program.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace coppice::bake {

Result<std::filesystem::path> find_program(const std::string& name) {
  std::error_code unknown;
  const std::filesystem::path own_folder = std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path();
  const char* path = std::getenv("PATH");
  std::istringstream folders(own_folder.string() + ":" + (path != nullptr ? path : ""));
  for (std::string folder; std::getline(folders, folder, ':');) {
    const std::filesystem::path file = std::filesystem::path(folder.empty() ? "." : folder) / name;
    if (std::filesystem::is_regular_file(file, unknown) && ::access(file.c_str(), X_OK) == 0) return file;
  }
  return Error{Status::io, "a program is missing", Error::kNoOffset,
               name + " is neither in " + own_folder.string() + ", beside this program, nor in a folder of PATH. The build target " +
                   "coppice_tools builds all programs, and the component coppice_tools installs them"};
}

Error start_program(const std::filesystem::path& program, std::vector<std::string> words) {
  words.insert(words.begin(), program.string());
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  static_cast<void>(std::fflush(nullptr));
  ::execv(program.c_str(), pointers.data());
  return Error{Status::io, "cannot start", Error::kNoOffset, program.string() + ": " + std::strerror(errno)};
}

}  // namespace coppice::bake
