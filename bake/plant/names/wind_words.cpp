#include "wind_words.h"

#include <string>

namespace coppice::bake {

bool names_wind(std::string_view name) {
  std::string word;
  const auto is_wind = [&] { return word == "wind" || word == "sway" || word == "bend" || word == "flutter"; };
  bool was_small = false;
  for (const char letter : name) {
    const bool capital = letter >= 'A' && letter <= 'Z', small = letter >= 'a' && letter <= 'z';
    if (!(capital || small) || (capital && was_small)) {
      if (is_wind()) return true;
      word.clear();
    }
    if (capital || small) word += static_cast<char>(capital ? letter - 'A' + 'a' : letter);
    was_small = small;
  }
  return is_wind();
}

}  // namespace coppice::bake
