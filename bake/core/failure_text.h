#pragma once

#include <exception>
#include <string>

namespace coppice::bake {

/// What an exception says; of one that TBB throws where it could start no thread, that and the operating system's reason.
std::string failure_text(const std::exception& error);

}  // namespace coppice::bake
