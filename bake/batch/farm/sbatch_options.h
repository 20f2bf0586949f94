#pragma once

// Options of sbatch as a user gives them: "-c 4", "-c4", "--cpus-per-task 4" or "--cpus-per-task=4".

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace coppice::bake {

/// The value of an option; of several, the last, as with sbatch. Empty where no value follows; nothing without the option.
/// @param names of the option, with their hyphens
std::optional<std::string_view> sbatch_value(const std::vector<std::string>& options, std::initializer_list<std::string_view> names);

/// Processors that each task gets: --cpus-per-task; 1
std::uint32_t processors_of_task(const std::vector<std::string>& options);

/// Whether they say how much memory tasks get. Slurm takes no two of its options for memory.
bool say_memory(const std::vector<std::string>& options);

/// The first that is coppice's own: it finds its tasks by their name, array and cluster. Empty without one.
std::string_view reserved_option(const std::vector<std::string>& options);

}  // namespace coppice::bake
