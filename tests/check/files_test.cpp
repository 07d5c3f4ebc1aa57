#include "check/files.h"

#include <set>
#include <string>

#include <doctest/doctest.h>

using meshgauge::check::picture_name;

TEST_CASE("files: a picture has the name of its gate, as far as every file system takes it") {
  CHECK(picture_name("bracket") == "bracket.png");
  CHECK(picture_name("lod-1_a.v2") == "lod-1_a.v2.png");
  CHECK(picture_name("Bracket").starts_with("bracket~"));
  CHECK(picture_name("parts/a b|c").starts_with("parts-a-b-c~"));
  CHECK(picture_name("").starts_with("gate~"));
}

TEST_CASE("files: pictures of two gates are two files, of names that mean nothing to shells, pages and paths") {
  std::set<std::string> seen;
  std::set<std::string> names = {"", "a", "A", "a.png", ".", "..", "../a", "-a", "a-", "a--b", "a-b", "a b", "a/b"};
  names.insert({"\n", "~", "--> <!--", "ä", "Ä", "%2e%2e", "a~b", std::string(300, 'x'), std::string(301, 'x')});
  for (const std::string& name : names) {
    const std::string file = picture_name(name);
    CHECK(file.size() <= 120);
    CHECK(file.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_.~") == std::string::npos);
    CHECK(file.find_first_of("-.~") != 0);
    CHECK(seen.insert(file).second);
  }
}
