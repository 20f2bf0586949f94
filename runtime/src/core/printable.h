#pragma once

#include <string>
#include <string_view>

namespace coppice {

/// `text` as it may be printed on a terminal, on one line. Control characters (C0, DEL, C1), line and paragraph separators, characters that
/// change the direction of writing, and bytes that are not UTF-8 become \xNN, one for each byte. Names come from files, and a terminal
/// obeys what it is sent.
std::string printable(std::string_view text);

/// Whether printable(text) is `text` itself.
bool is_printable(std::string_view text);

}  // namespace coppice
