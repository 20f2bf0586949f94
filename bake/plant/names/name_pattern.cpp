#include "name_pattern.h"

#include <algorithm>
#include <utility>

#include <re2/re2.h>

#include "printable.h"

namespace coppice::bake {
namespace {

constexpr std::size_t kShownChars = 64;

re2::StringPiece piece(std::string_view text) {
  return {text.data(), text.size()};
}

}  // namespace

NamePattern::NamePattern(std::unique_ptr<re2::RE2> pattern) : pattern_(std::move(pattern)) {}
NamePattern::NamePattern(NamePattern&&) noexcept = default;
NamePattern& NamePattern::operator=(NamePattern&&) noexcept = default;
NamePattern::~NamePattern() = default;

Result<NamePattern> NamePattern::compile(std::string_view text, const std::string& source) {
  re2::RE2::Options options;
  options.set_log_errors(false);
  auto pattern = std::make_unique<re2::RE2>(piece(text), options);
  if (pattern->ok()) return NamePattern(std::move(pattern));
  std::string shown = printable(text.substr(0, kShownChars));
  if (text.size() > kShownChars) shown += "...";
  // RE2 quotes the part that it rejects, which may be all of the text.
  const std::string& reason = pattern->error();
  return Error{Status::invalid_argument, "not a regular expression", Error::kNoOffset,
               source + ": " + shown + ": " + reason.substr(0, std::min(reason.find(": "), kShownChars))};
}

bool NamePattern::is_in(std::string_view name) const {
  return re2::RE2::PartialMatch(piece(name), *pattern_);
}

std::string NamePattern::without(std::string_view name) const {
  std::string rest(name);
  re2::RE2::Replace(&rest, *pattern_, "");
  return rest;
}

}  // namespace coppice::bake
