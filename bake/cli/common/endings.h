#pragma once

// How the program ends when a command cannot: out of memory, by a signal, by an exception that nobody may catch. In each case temporary
// files go first.

namespace coppice::bake {

/// To be called first of all: from then on signals that end the program remove its temporary files. Linking this file is enough for the
/// rest: an allocation by `new` that fails, in whatever library, ends the program with "coppice: out of memory" and exit code 1.
void install_endings();

/// Says that memory has run out and ends the program. Allocates nothing.
[[noreturn]] void end_out_of_memory() noexcept;

}  // namespace coppice::bake
