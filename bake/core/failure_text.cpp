#include "failure_text.h"

#include <string_view>

namespace coppice::bake {

std::string failure_text(const std::exception& error) {
  constexpr std::string_view kTbbs = "pthread_create has failed";
  const std::string text = error.what();
  return text.starts_with(kTbbs) ? "cannot start a thread" + text.substr(kTbbs.size()) : text;
}

}  // namespace coppice::bake
