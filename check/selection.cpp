#include "check/selection.h"

#include <algorithm>

#include "check/manifest/glob.h"

namespace meshgauge::check {
namespace {

// With '*' for all that is not plain.
std::string simplified(std::string_view pattern) {
  std::string out;
  while (!pattern.empty()) {
    const std::size_t closed = pattern[0] == '[' ? pattern.find(']', 2) : std::string_view::npos;
    const bool any = closed != std::string_view::npos || pattern[0] == '*' || pattern[0] == '?';
    out += any ? '*' : pattern[0];
    pattern.remove_prefix(closed == std::string_view::npos ? 1 : closed + 1);
  }
  return out;
}

// Whether there is a text that both match. `row[j]`: whether the rests of `a` from i and of `b` from j meet.
bool meet(const std::string& a, const std::string& b) {
  std::vector<char> below, row(b.size() + 1);
  for (std::size_t i = a.size() + 1; i-- > 0; below = row) {
    for (std::size_t j = b.size() + 1; j-- > 0;) {
      const bool more_a = i < a.size(), more_b = j < b.size();
      const bool star_a = more_a && a[i] == '*', star_b = more_b && b[j] == '*';
      if (star_a || star_b) {
        row[j] = (more_a && (star_a || star_b) && below[j]) || (more_b && row[j + 1]);
      } else {
        row[j] = more_a == more_b && (!more_a || (a[i] == b[j] && below[j + 1]));
      }
    }
  }
  return row[0] != 0;
}

}  // namespace

bool Selection::holds(std::string_view name) const {
  const auto matching = [&](const std::string& pattern) { return matches(pattern, std::string(name)); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), matching);
}

bool Selection::may_hold(std::string_view name_pattern) const {
  const std::string names = simplified(name_pattern);
  const auto meeting = [&](const std::string& pattern) { return meet(simplified(pattern), names); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), meeting);
}

}  // namespace meshgauge::check
