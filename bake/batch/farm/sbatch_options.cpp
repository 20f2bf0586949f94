#include "sbatch_options.h"

#include <algorithm>
#include <array>

#include "text_number.h"

namespace coppice::bake {

std::optional<std::string_view> sbatch_value(const std::vector<std::string>& options, std::initializer_list<std::string_view> names) {
  std::optional<std::string_view> value;
  for (std::size_t i = 0; i < options.size(); ++i)
    for (const std::string_view name : names) {
      const std::string_view word = options[i];
      const bool is_long = name.starts_with("--");
      if (word == name)
        value = i + 1 < options.size() ? std::string_view(options[i + 1]) : std::string_view{};
      else if (word.starts_with(name) && (!is_long || word[name.size()] == '='))
        value = word.substr(name.size() + (is_long ? 1 : 0));
    }
  return value;
}

std::uint32_t processors_of_task(const std::vector<std::string>& options) {
  const auto count = number_of<std::uint32_t>(sbatch_value(options, {"--cpus-per-task", "-c"}).value_or(""));
  return std::max(count.value_or(1), 1u);
}

bool say_memory(const std::vector<std::string>& options) {
  return sbatch_value(options, {"--mem", "--mem-per-cpu", "--mem-per-gpu"}).has_value();
}

std::string_view reserved_option(const std::vector<std::string>& options) {
  constexpr std::array kNames{"-J", "--job-name", "-a", "--array", "-M", "--clusters", "--wrap", "-W", "--wait"};
  const auto found = std::ranges::find_if(kNames, [&](const char* name) { return sbatch_value(options, {name}).has_value(); });
  return found == kNames.end() ? std::string_view{} : *found;
}

}  // namespace coppice::bake
