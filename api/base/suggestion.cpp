#include "api/base/suggestion.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kLongestWord = 64;  // no key is longer

std::string folded(std::string_view word) {
  std::string out = lower_case(std::string(word));
  for (char& c : out) {
    if (c == '-' || c == ' ') c = '_';
  }
  return out;
}

// Optimal string alignment distance: letters to insert, remove, replace, or swap with the next.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t k = 1; k <= b.size(); ++k) {
      row[k] = std::min({last[k] + 1, row[k - 1] + 1, last[k - 1] + (a[i - 1] != b[k - 1])});
      const bool swapped = i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1];
      if (swapped) row[k] = std::min(row[k], before[k - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

bool begins_alike(std::string_view a, std::string_view b) {
  return std::min(a.size(), b.size()) >= 4 && (a.starts_with(b) || b.starts_with(a));
}

}  // namespace

std::string_view nearest(std::string_view word, std::span<const std::string_view> known) {
  if (word.size() > kLongestWord) return {};
  const std::string meant = folded(word);
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(1, meant.size() / 3) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t reached = begins_alike(meant, candidate) ? 1 : distance(meant, candidate);
    if (reached >= best_distance) continue;
    best = candidate;
    best_distance = reached;
  }
  return best;
}

std::string suggestion(std::string_view word, std::span<const std::string_view> known) {
  const std::string_view meant = nearest(word, known);
  if (!meant.empty()) return "; did you mean '" + std::string(meant) + "'?";
  std::string list;
  for (const std::string_view one : known) list.append(list.empty() ? "; known: " : ", ").append(one);
  return list;
}

}  // namespace meshgauge::api
