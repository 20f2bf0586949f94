#include "file_place.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <string_view>
#include <system_error>
#include <vector>

#include "io_result.h"

namespace coppice::bake {
namespace {

constexpr int kMostLinks = 40;
constexpr const char* kNoFolder = "cannot open the folder of";

Descriptor open_folder(int from, const char* name) {
  return Descriptor(::openat(from, name, O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
}

Descriptor start_of(const std::filesystem::path& path) {
  return open_folder(AT_FDCWD, path.is_absolute() ? "/" : ".");
}

/// Puts the names of a path before those that are left. They are in reverse, the next one last.
void put_first(const std::filesystem::path& path, std::vector<std::string>& left) {
  std::vector<std::string> names;
  for (const std::filesystem::path& name : path.relative_path()) names.push_back(name.native());
  left.insert(left.end(), names.rbegin(), names.rend());
}

bool leads_on(const struct stat& link, const Descriptor& folder) {
  if (link.st_uid == ::geteuid() || link.st_uid == 0) return true;
  struct stat status {};
  return ::fstat(folder.number(), &status) == 0 && (link.st_uid == status.st_uid || (status.st_mode & (S_IWGRP | S_IWOTH)) == 0);
}

/// Replaces the link `name` by what it says. errors  of the system, by number; 0: none
int follow(const std::string& name, Descriptor& folder, std::vector<std::string>& left) {
  std::array<char, PATH_MAX> text{};
  const ssize_t bytes = ::readlinkat(folder.number(), name.c_str(), text.data(), text.size());
  if (bytes < 0) return errno;
  const std::filesystem::path target(std::string_view(text.data(), static_cast<std::size_t>(bytes)));
  if (target.is_absolute()) folder = start_of(target);
  put_first(target, left);
  return left.empty() ? EISDIR : 0;  // a link to the root
}

}  // namespace

Descriptor::~Descriptor() {
  if (number_ >= 0) ::close(number_);
}

Error system_error(const char* what, const std::filesystem::path& path, int reason) {
  return Error{status_of(reason), what, Error::kNoOffset, path.string() + ": " + std::strerror(reason)};
}

Result<FilePlace> find_place(const std::filesystem::path& path, LastLink last, MissingFolders missing) {
  if (path.empty()) return Error{Status::io, "cannot write", Error::kNoOffset, "the output has no name"};
  if (!path.has_filename()) return system_error(kNoFolder, path, EISDIR);
  std::vector<std::string> left;
  put_first(path, left);
  FilePlace place{start_of(path), {}, path};
  for (int links_left = kMostLinks;;) {
    const std::string name = std::exchange(left.back(), {});
    left.pop_back();
    const bool is_last = left.empty();
    struct stat status {};
    const int reason = ::fstatat(place.folder.number(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 ? 0 : errno;
    const bool is_link = reason == 0 && S_ISLNK(status.st_mode);
    if (is_link && (!is_last || last == LastLink::followed) && leads_on(status, place.folder)) {
      const int failed = links_left-- == 0 ? ELOOP : follow(name, place.folder, left);
      if (failed != 0) return system_error(kNoFolder, path, failed);
    } else if (is_last) {
      place.name = name.empty() ? "." : name;  // a link's text may end with a slash
      return place;
    } else if (is_link) {
      return Error{Status::io, kNoFolder, Error::kNoOffset, path.string() + ": " + name + " is a link that another user made"};
    } else if (!name.empty()) {
      if (reason == ENOENT && missing == MissingFolders::are_made && ::mkdirat(place.folder.number(), name.c_str(), 0777) != 0 &&
          errno != EEXIST)
        return system_error("cannot make the folder of", path, errno);
      Descriptor next = open_folder(place.folder.number(), name.c_str());
      if (next.number() < 0) return system_error(kNoFolder, path, errno);
      place.folder = std::move(next);
    }
  }
}

Result<std::filesystem::path> resolved(const std::filesystem::path& path) {
  std::filesystem::path left = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::error_code error;
    const std::filesystem::path found = std::filesystem::weakly_canonical(std::filesystem::current_path(error) / left, error);
    if (error == std::errc::not_enough_memory) return system_error("cannot resolve", path, error.value());
    if (error) break;
    // Here stands what is there; what follows may begin with a link to nowhere, and that is written through.
    std::filesystem::path at, next;
    for (const std::filesystem::path& name : found) {
      at /= name;
      const bool leads_on = next.empty() && std::filesystem::is_symlink(at, error);
      next = leads_on ? at.parent_path() / std::filesystem::read_symlink(at, error) : next.empty() ? next : next / name;
    }
    if (next.empty()) return found;
    left = next;
  }
  return path.lexically_normal();
}

Result<FilePlace> beside(const FilePlace& place, const std::string& name) {
  Descriptor folder(::fcntl(place.folder.number(), F_DUPFD_CLOEXEC, 0));
  std::filesystem::path path = place.path.parent_path() / name;
  if (folder.number() < 0) return system_error(kNoFolder, path, errno);
  return FilePlace{std::move(folder), name, std::move(path)};
}

}  // namespace coppice::bake
