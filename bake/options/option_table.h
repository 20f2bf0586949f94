#pragma once

// The options of a bake, each described once. The command line and its help, shell completion, lists of bake-all and the cache's key are
// all made from this table.
//
// A new option is a member of BakeOptions or ImportOptions and a row here. Its `get` gives nothing at the default, or every plant in a
// cache is baked again. option_parts() of batch/bake_key.cpp does not compile until it counts the member; cache_test.cpp names every
// option.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bake.h"
#include "result.h"

namespace coppice::bake {

/// What a user asks for, before files are read: bake_options() makes it a bake's options.
struct BakeRequest {
  BakeOptions options;
  std::string classes;  ///< a file of rules, or the rules themselves as JSON; empty: none
  bool quick = false;
  bool all_variants = false;  ///< a bake for each variant of the file
};

/// Where options belong: `evaluate` and `scene` take some groups alone.
enum class OptionGroup : std::uint8_t { bake, classes, units, plant };

struct BakeOption {
  std::string name;  ///< "wind-stiffness": --wind-stiffness, and "wind_stiffness" in lists
  std::string type;  ///< the value's type for people: "on|off", "N"; empty: a flag
  std::string help;
  OptionGroup group = OptionGroup::bake;
  /// errors  invalid_argument: `text` is no value of this option; the message says what is
  std::function<Result<void>(BakeRequest& request, const std::string& text)> set;
  /// The value as a text that set() reads back exactly. Nothing: it is as if the option were not given.
  std::function<std::optional<std::string>(const BakeOptions& options)> get;
  bool changes_result = true;  ///< part of the cache's key
};

/// Every option that changes a bake's result or what it may read.
const std::vector<BakeOption>& bake_option_table();

/// errors  io, bad_file: the file of classes; invalid_argument: check_areas
Result<BakeOptions> bake_options(const BakeRequest& request);

}  // namespace coppice::bake
