#include "check/selection.h"

#include <doctest/doctest.h>

using meshgauge::check::Selection;

TEST_CASE("selection: names by any of its patterns") {
  CHECK(Selection().holds("anything"));
  const Selection some({"lod-*", "p?n", "[ab]\\c"});
  for (const char* name : {"lod-1", "lod-", "pin", "p\xC3\xA4n", "lod-near/x", "a\\c"}) CHECK(some.holds(name));
  for (const char* name : {"xlod-1", "pn", "piin", "ac", "c\\c", ""}) CHECK(!some.holds(name));
}

TEST_CASE("selection: names that are known in part") {
  const auto may = [](const char* pattern, const char* names) { return Selection({pattern}).may_hold(names); };
  CHECK(Selection().may_hold("*"));
  for (const char* names : {"*", "lod-*", "lod-a", "*-a", "l*d*a", "**"}) CHECK(may("lod-?", names));
  for (const char* names : {"part-*", "lo", "*b-", "lod", "lod*_"}) CHECK(!may("lod-a", names));
  CHECK(!may("lod-a*", "lod-b*"));
  CHECK(!may("*-a", "lod-*-b"));
  CHECK(may("*x", "x*"));
  CHECK(may("a*c", "*b*"));
  CHECK(!may("a*c", "b*"));
}
