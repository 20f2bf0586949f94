#pragma once

// Pages that open without a network: all that they show is inside.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace coppice::bake {

/// "data:image/png;base64,…", for media_type "image/png".
std::string data_url(std::string_view media_type, std::span<const std::uint8_t> bytes);

/// JSON that cannot end the script element that holds it: strings alone have '<', and there it can be written as an escape.
std::string json_for_script(std::string_view json);

/// The page with each name's first place after that of the name before filled with its text. Names are in the page, in its order, so that
/// what was put in is never searched.
std::string filled_page(std::string_view page, std::span<const std::pair<std::string_view, std::string_view>> parts);

}  // namespace coppice::bake
