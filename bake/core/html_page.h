#pragma once

// Builds HTML pages that open without a network: the file holds all that they show.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace coppice::bake {

/// Returns "data:image/png;base64,…" for media_type "image/png".
std::string data_url(std::string_view media_type, std::span<const std::uint8_t> bytes);

/// Escapes JSON so that it cannot end the script element that holds it. JSON has '<' only in strings, where an escape may replace it.
std::string json_for_script(std::string_view json);

/// Fills a page: replaces each name by its text, at the name's first place after that of the name before. Names stand in the page's order,
/// so that text that was filled in is never searched.
std::string filled_page(std::string_view page, std::span<const std::pair<std::string_view, std::string_view>> parts);

}  // namespace coppice::bake
