#include "api/formats/unread.h"

#include <algorithm>

#include "api/base/text.h"

namespace meshgauge::api {

void Unread::add(std::string_view kind, std::size_t count) {
  const bool full = kinds_.size() == kMostKinds;
  std::string name = printable(kind, kLongestKind);
  auto known = std::ranges::find(kinds_, name, [](const auto& one) { return one.first; });
  if (known == kinds_.end() && full) known = kinds_.end() - 1;
  if (known == kinds_.end()) {
    if (kinds_.size() + 1 == kMostKinds) name = "all other kinds";
    known = kinds_.emplace(kinds_.end(), std::move(name), 0);
  }
  known->second += count;
}

std::vector<std::string> Unread::remarks() const {
  std::vector<std::string> remarks;
  for (const auto& [kind, count] : kinds_) {
    remarks.push_back(std::string(kRemark) + ": " + kind + ": " + std::to_string(count));
  }
  return remarks;
}

std::string Unread::refusal() const {
  std::string all;
  for (const auto& [kind, count] : kinds_) {
    all += (all.empty() ? "" : ", ") + kind + ": " + std::to_string(count);
  }
  return "has no triangles, only what is not read (" + all + "): export it as triangles";
}

}  // namespace meshgauge::api
