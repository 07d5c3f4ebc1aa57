// Selects gates of a manifest by name: --only.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meshgauge::check {

class Selection {
 public:
  Selection() = default;  // all gates
  // Selects the gates that one of the patterns matches. Patterns have *, ? and [..]; '?' stands for one character of
  // UTF-8.
  explicit Selection(std::vector<std::string> patterns) : patterns_(std::move(patterns)) {}

  const std::vector<std::string>& patterns() const { return patterns_; }
  bool holds(std::string_view name) const;

  // Whether a name of this pattern could be selected; the pattern is the name of a gate whose candidate was not
  // found. When in doubt: true.
  bool may_hold(std::string_view name_pattern) const;

 private:
  std::vector<std::string> patterns_;
};

}  // namespace meshgauge::check
