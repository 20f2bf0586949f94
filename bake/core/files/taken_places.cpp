#include "taken_places.h"

#include <sys/stat.h>

#include "file_place.h"

namespace coppice::bake {

Result<bool> TakenPlaces::add(const std::filesystem::path& path) {
  struct stat status {};
  const bool is_there = ::stat(path.c_str(), &status) == 0;
  if (path.empty() || (is_there && S_ISCHR(status.st_mode))) return true;
  COPPICE_TRY(place, resolved(path));
  const bool is_new = paths_.insert(std::move(place)).second;
  return (!is_there || files_.emplace(status.st_dev, status.st_ino).second) && is_new;
}

}  // namespace coppice::bake
