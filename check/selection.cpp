#include "check/selection.h"

#include <algorithm>

#include "check/manifest/glob.h"

namespace meshgauge::check {
namespace {

// Whether two patterns have the same beginning, up to the first wildcard of either, and the same end.
bool meet_at_ends(std::string_view a, std::string_view b) {
  const std::size_t first = std::min(a.find_first_of("*?["), b.find_first_of("*?["));
  const auto behind = [](std::string_view text) { return text.size() - 1 - text.find_last_of("*?]"); };
  const std::size_t last = std::min(behind(a), behind(b));
  return a.substr(0, first) == b.substr(0, first) && a.substr(a.size() - last) == b.substr(b.size() - last);
}

}  // namespace

bool Selection::holds(std::string_view name) const {
  const auto matching = [&](const std::string& pattern) { return matches(pattern, std::string(name)); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), matching);
}

bool Selection::may_hold(std::string_view name_pattern) const {
  if (!is_glob(name_pattern)) return holds(name_pattern);
  const auto meeting = [&](const std::string& pattern) { return meet_at_ends(pattern, name_pattern); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), meeting);
}

}  // namespace meshgauge::check
