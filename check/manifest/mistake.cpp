#include "check/manifest/mistake.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

namespace meshgauge::check {

void Mistakes::add(Place place, std::string message) { all_.push_back({place.line, place.column, std::move(message)}); }

std::vector<Mistake> Mistakes::sorted() && {
  std::set<std::tuple<int, int, std::string>> told;
  std::erase_if(all_, [&](const Mistake& m) { return !told.emplace(m.line, m.column, m.message).second; });
  const auto same_place = [](const Mistake& m) { return std::tie(m.line, m.column); };
  std::stable_sort(all_.begin(), all_.end(),
                   [&](const Mistake& x, const Mistake& y) { return same_place(x) < same_place(y); });
  if (all_.size() > kMost) {
    const std::string rest = "and " + std::to_string(all_.size() - kMost) + " more mistakes";
    all_.resize(kMost);
    all_.push_back({0, 0, rest});
  }
  return std::move(all_);
}

std::string to_string(std::string_view file, const Mistake& mistake) {
  std::string text(file);
  if (mistake.line > 0) text += ":" + std::to_string(mistake.line) + ":" + std::to_string(mistake.column);
  return text + ": " + mistake.message;
}

}  // namespace meshgauge::check
