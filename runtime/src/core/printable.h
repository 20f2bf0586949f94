#pragma once

#include <string>
#include <string_view>

namespace coppice {

/// Makes text safe to print on a terminal, on one line, because names come from files and terminals obey control characters. Control
/// characters (C0, DEL, C1), line and paragraph separators, characters that change the direction of writing, and bytes that are not UTF-8
/// become \xNN, one for each byte.
std::string printable(std::string_view text);

/// True if printable(text) is `text` itself.
bool is_printable(std::string_view text);

/// True if a byte is one of ASCII's control characters, NUL and DEL too: no path in a file may have one.
bool has_control_character(std::string_view text);

}  // namespace coppice
