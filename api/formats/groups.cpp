#include "api/formats/groups.h"

#include <algorithm>
#include <utility>

#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

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
  if (name.empty() || name.size() > kMostBytesOfGroup) return false;
  while (!name.empty()) {
    const Character next = meshgauge::decode(name);
    if (next.bytes == 0 || is_hidden(next.code)) return false;
    name.remove_prefix(next.bytes);
  }
  return true;
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
  TriangleRange range{static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(end)};
  auto known = named_.find(name);
  if (known == named_.end()) {
    known = named_.try_emplace(std::string(name)).first;
    bytes_ += name.size();
  }
  // Joins what overlaps or touches: the ranges of a name are disjoint and in order.
  std::vector<TriangleRange>& ranges = known->second;
  for (; !ranges.empty() && ranges.back().end >= range.first; ranges.pop_back(), --ranges_)
    range = {std::min(range.first, ranges.back().first), std::max(range.end, ranges.back().end)};
  ranges.push_back(range);
  if (++ranges_ > kMostGroupRanges || bytes_ > kMostBytesOfGroups) give_up();
}

void GroupCollector::give_up() {
  too_many_ = true;
  named_.clear();
}

Groups GroupCollector::take() {
  Groups groups{{}, too_many_};
  groups.named.reserve(named_.size());
  for (auto& [name, ranges] : named_) groups.named.push_back({name, std::move(ranges)});
  named_.clear();
  return groups;
}

}  // namespace meshgauge::api
