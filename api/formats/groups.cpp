#include "api/formats/groups.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "api/formats/utf8.h"

namespace meshgauge::api {
namespace {

// Sorts the ranges and joins those that overlap or touch.
void join(std::vector<TriangleRange>& ranges) {
  std::ranges::sort(ranges, {}, &TriangleRange::first);
  std::size_t last = 0;
  for (const TriangleRange& next : ranges) {
    if (next.first <= ranges[last].end) {
      ranges[last].end = std::max(ranges[last].end, next.end);
    } else {
      ranges[++last] = next;
    }
  }
  ranges.resize(last + 1);
}

bool is_valid(const Group& group, std::size_t triangles) {
  std::uint32_t end = 0;
  for (const TriangleRange& range : group.ranges) {
    if (range.first < end || range.end <= range.first) return false;
    end = range.end;
  }
  return is_group_name(group.name) && !group.ranges.empty() && end <= triangles;
}

}  // namespace

bool is_group_name(std::string_view name) {
  return !name.empty() && name.size() <= kMostBytesOfGroup && is_utf8(name) &&
         find_control(name) == std::string_view::npos;
}

bool is_valid(const Groups& groups, std::size_t triangles) {
  return std::ranges::all_of(groups.named, [&](const Group& group) { return is_valid(group, triangles); }) &&
         std::ranges::is_sorted(groups.named, std::ranges::less_equal(), &Group::name);
}

const Group* find_group(const Groups& groups, std::string_view name) {
  const auto found = std::ranges::lower_bound(groups.named, name, {}, &Group::name);
  return found != groups.named.end() && found->name == name ? &*found : nullptr;
}

std::size_t bytes_of(const Groups& groups) {
  std::size_t bytes = groups.named.size() * sizeof(Group);
  for (const Group& group : groups.named) bytes += group.name.size() + group.ranges.size() * sizeof(TriangleRange);
  return bytes;
}

void GroupCollector::add(std::string_view name, std::size_t first, std::size_t end) {
  if (too_many_ || first >= end || !is_group_name(name)) return;
  const TriangleRange range{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)};
  auto known = named_.find(name);
  if (known == named_.end()) {
    known = named_.try_emplace(std::string(name)).first;
    bytes_ += name.size();
  } else if (TriangleRange& last = known->second.back(); last.end == range.first) {
    last.end = range.end;
    return;
  }
  known->second.push_back(range);
  too_many_ = ++ranges_ > kMostGroupRanges || bytes_ > kMostBytesOfGroups;
  if (too_many_) named_.clear();
}

Groups GroupCollector::take() {
  Groups groups{{}, too_many_};
  groups.named.reserve(named_.size());
  for (auto& [name, ranges] : named_) {
    join(ranges);
    groups.named.push_back({name, std::move(ranges)});
  }
  named_.clear();
  return groups;
}

}  // namespace meshgauge::api
