#include "api/formats/unread.h"

#include <doctest/doctest.h>

#include "api/formats/format.h"

namespace meshgauge::api {
namespace {

TEST_CASE("unread: a remark for each kind, in the order of first appearance") {
  Unread unread;
  CHECK(unread.empty());
  unread.add("free-form surfaces (surf)");
  unread.add("curves (curv2)", 3);
  unread.add("free-form surfaces (surf)");
  CHECK(unread.remarks() ==
        std::vector<std::string>{"not read and not measured, though part of the surface: free-form surfaces (surf): 2",
                                 "not read and not measured, though part of the surface: curves (curv2): 3"});
  CHECK(unread.refusal() ==
        "has no triangles, only what is not read (free-form surfaces (surf): 2, curves (curv2): 3): export it as "
        "triangles");
}

TEST_CASE("unread: any number of kinds of any length fits the remarks of a mesh") {
  Unread unread;
  for (int i = 0; i < 1000; ++i) unread.add(std::to_string(i) + std::string(500, '\x01'), 2);
  const auto remarks = unread.remarks();
  REQUIRE(remarks.size() == Unread::kMostKinds);
  CHECK(remarks.size() < kMaxRemarks);
  CHECK(remarks.back() == "not read and not measured, though part of the surface: all other kinds: 1986");
  for (const std::string& remark : remarks) CHECK(remark.size() <= kMaxRemarkBytes);
}

}  // namespace
}  // namespace meshgauge::api
