// Which gates of a manifest are asked for: --only.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meshgauge::check {

class Selection {
 public:
  Selection() = default;  // all gates
  // Patterns of *, ? and [..], in which '?' stands for one character of UTF-8; a gate that one of them matches is asked
  // for.
  explicit Selection(std::vector<std::string> patterns) : patterns_(std::move(patterns)) {}

  const std::vector<std::string>& patterns() const { return patterns_; }
  bool holds(std::string_view name) const;

  // Whether it could hold a name of which only a pattern is known, that of a gate whose candidate was not found. Rather
  // yes than no.
  bool may_hold(std::string_view name_pattern) const;

 private:
  std::vector<std::string> patterns_;
};

}  // namespace meshgauge::check
