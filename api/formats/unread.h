// Counts what a file holds of a surface and its reader does not read. Readers only add; read_mesh() notes or refuses.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace meshgauge::api {

class Unread {
 public:
  static constexpr std::size_t kMostKinds = 8;
  static constexpr std::size_t kLongestKind = 100;

  // `kind` is a plural: "free-form surfaces (surf)". Keeps kMostKinds kinds of kLongestKind printable characters, and
  // counts all others as one. Takes constant time.
  void add(std::string_view kind, std::size_t count = 1);

  bool empty() const { return kinds_.empty(); }

  // Begins each remark.
  static constexpr std::string_view kRemark = "not read and not measured, though part of the surface";

  // Returns a remark for each kind, in the order of first appearance:
  // "not read and not measured, though part of the surface: free-form surfaces (surf): 2".
  std::vector<std::string> remarks() const;

  // Returns what a refusal says of a file without any other surface.
  std::string refusal() const;

 private:
  std::vector<std::pair<std::string, std::size_t>> kinds_;
};

}  // namespace meshgauge::api
