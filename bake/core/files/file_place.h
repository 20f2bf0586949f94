#pragma once

// Places in folders that other people may write to. A path is walked once, name by name; from then on a file is a name in an open folder,
// so that nobody can put another folder or a link in its way.

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>

#include "result.h"

namespace coppice::bake {

/// An open file of the operating system, which is closed at the end. number  negative: there is none
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~Descriptor();
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// Makes the error of a failed system call on `path`, with the operating system's reason. Its status is out_of_memory for ENOMEM, else io.
Error system_error(const char* what, const std::filesystem::path& path, int reason);

struct FilePlace {
  Descriptor folder;           ///< only for calls that take a folder and a name (O_PATH)
  std::string name;            ///< in the folder
  std::filesystem::path path;  ///< as it was given, for messages
};

/// What becomes of a symbolic link that has the file's name.
enum class LastLink : std::uint8_t { followed, stays };
enum class MissingFolders : std::uint8_t { fail, are_made };

/// Finds the place of a file, which need not be there. Symbolic links lead on if the user or root made them, or if they are in a folder
/// that only its owner writes to; any other may be a trap. Such a link on the way is an error, and at the end stays.
/// errors  io: the path, with the system's reason; it has no name at its end
Result<FilePlace> find_place(const std::filesystem::path& path, LastLink last = LastLink::followed,
                             MissingFolders missing = MissingFolders::fail);

/// Where a path leads, from the root, whatever of it is there; also by links to what is not. By its letters alone where folders of it
/// cannot be looked into. errors  out_of_memory
Result<std::filesystem::path> resolved(const std::filesystem::path& path);

/// Another name in the folder of a place, and the place itself once more. errors  io: too many files are open
Result<FilePlace> beside(const FilePlace& place, const std::string& name);

}  // namespace coppice::bake
