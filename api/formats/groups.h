// The named parts of a file: groups and objects of an OBJ, nodes of a glTF, objects of a 3MF.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engine/region.h"

namespace meshgauge::api {

inline constexpr std::size_t kMostBytesOfGroup = 256;  // of a name
inline constexpr std::size_t kMostBytesOfGroups = std::size_t{1} << 20;
inline constexpr std::size_t kMostGroupRanges = std::size_t{1} << 16;

struct Groups {
  std::vector<Group> named;  // by their names, each once
  bool too_many = false;     // more names or ranges than the constants above allow: none is kept

  bool operator==(const Groups&) const = default;
};

// Whether a part may be asked for by this name: 1 to kMostBytesOfGroup bytes of UTF-8 without hidden characters.
bool is_group_name(std::string_view name);

// Whether the groups are as GroupCollector makes them, of a mesh with this many triangles.
bool is_valid(const Groups& groups, std::size_t triangles);

// nullptr: there is no such group.
const Group* find_group(const Groups& groups, std::string_view name);

std::size_t bytes_of(const Groups& groups);  // of memory, beside the object itself

// Collects the groups while a reader adds triangles. Linear time, up to a logarithm; bounded memory.
class GroupCollector {
 public:
  // Adds triangles first to end - 1 to the group. Does nothing when there are none, or for what is no name of a group.
  void add(std::string_view name, std::size_t first, std::size_t end);
  void give_up();  // makes take() return too_many
  Groups take();

 private:
  std::map<std::string, std::vector<TriangleRange>, std::less<>> named_;
  std::size_t bytes_ = 0;
  std::size_t ranges_ = 0;
  bool too_many_ = false;
};

}  // namespace meshgauge::api
