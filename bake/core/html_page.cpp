#include "html_page.h"

#include <algorithm>
#include <cstddef>

namespace coppice::bake {
namespace {

std::string base64(std::span<const std::uint8_t> bytes) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t j = 0; j < 3; ++j) group = group << 8 | (j < count ? bytes[i + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= count ? kDigits[group >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

}  // namespace

std::string data_url(std::string_view media_type, std::span<const std::uint8_t> bytes) {
  return "data:" + std::string(media_type) + ";base64," + base64(bytes);
}

std::string json_for_script(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char letter : json)
    if (letter == '<')
      text += "\\u003c";
    else
      text += letter;
  return text;
}

std::string filled_page(std::string_view page, std::span<const std::pair<std::string_view, std::string_view>> parts) {
  std::string filled;
  for (const auto& [name, text] : parts) {
    const std::size_t at = page.find(name);
    filled.append(page.substr(0, at)).append(text);
    page.remove_prefix(at + name.size());
  }
  return filled.append(page);
}

}  // namespace coppice::bake
