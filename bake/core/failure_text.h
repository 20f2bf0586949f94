#pragma once

#include <exception>
#include <string>

namespace coppice::bake {

/// The exception's message. If TBB could not start a thread, the operating system's reason follows.
std::string failure_text(const std::exception& error);

}  // namespace coppice::bake
