#pragma once

#include <exception>
#include <string>
#include <string_view>

namespace coppice::bake {

/// The exception's message. If TBB could not start a thread, the operating system's reason follows.
inline std::string failure_text(const std::exception& error) {
  constexpr std::string_view kTbbs = "pthread_create has failed";
  const std::string text = error.what();
  return text.starts_with(kTbbs) ? "cannot start a thread" + text.substr(kTbbs.size()) : text;
}

}  // namespace coppice::bake
