#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "result.h"

namespace re2 {
class RE2;
}

namespace coppice::bake {

/// A regular expression for names of materials and nodes, in RE2's syntax: that of ECMAScript without back-references and look-ahead.
/// Matching takes time in proportion to the name's length, and no stack, whatever the expression and the name are.
class NamePattern {
 public:
  /// text    UTF-8
  /// source  says in messages where the text stands: "--leaf-material", "oak.json: classes[2]"
  /// errors  invalid_argument: not a regular expression, or one that takes more than 8 MB; `detail` is source, reason and text
  static Result<NamePattern> compile(std::string_view text, const std::string& source);

  NamePattern(NamePattern&&) noexcept;
  NamePattern& operator=(NamePattern&&) noexcept;
  ~NamePattern();

  /// Whether it matches any part of the name; case matters.
  [[nodiscard]] bool is_in(std::string_view name) const;
  /// The name without what the pattern first matches.
  [[nodiscard]] std::string without(std::string_view name) const;

 private:
  explicit NamePattern(std::unique_ptr<re2::RE2> pattern);
  std::unique_ptr<re2::RE2> pattern_;
};

}  // namespace coppice::bake
