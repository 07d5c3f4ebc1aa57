#include "check/picture_name.h"

#include <set>
#include <string>

#include <doctest/doctest.h>

using meshgauge::check::picture_name;

TEST_CASE("a plain name is the picture's, any other one is shortened and has a digest") {
  CHECK(picture_name("bracket") == "bracket.png");
  CHECK(picture_name("part-7_b.stl") == "part-7_b.stl.png");
  const std::string odd = picture_name("Part A/B");
  CHECK(odd.starts_with("part-a-b-"));
  CHECK(odd.size() == std::string("part-a-b-1234567812345678.png").size());
  CHECK(odd == picture_name("Part A/B"));
}

TEST_CASE("no name leads into another folder, hides its file or shares it") {
  std::set<std::string> names;
  const std::string all[] = {"Part A",
                             "part-a-83d2558d4bdc274a",
                             "part-a-83d2558d",
                             "::",
                             "71546855d6279ef7",
                             "part",
                             "Part",
                             "PART",
                             "..",
                             ".",
                             "../part",
                             "/part",
                             "-part",
                             ".part",
                             "part.",
                             "a/b",
                             "a\\b",
                             "a b",
                             "a-b",
                             "a--b",
                             "\xE2\x80\xAE",
                             "\n",
                             "::error::",
                             std::string(500, 'a'),
                             std::string(501, 'a'),
                             std::string("a\0b", 3)};
  for (const std::string& name : all) {
    CAPTURE(name);
    const std::string file = picture_name(name);
    CHECK(file.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789._-") == std::string::npos);
    CHECK(file.ends_with(".png"));
    CHECK(file.find_first_of(".-") != 0);
    CHECK(file.size() < 100);
    CHECK(names.insert(file).second);
  }
}
