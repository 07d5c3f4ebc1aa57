#include "check/manifest/spelling.h"

#include <optional>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/manifest/glob.h"
#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;

TEST_CASE("spelling: what a pattern and a name differ by") {
  const Utf8Locale utf8;
  struct Row {
    const char *pattern, *name;
    std::optional<unsigned> differ;
  };
  for (const Row& row : {Row{"*.stl", "a.stl", 0U},
                         {"*.stl", "A.stl", 0U},
                         {"*.stl", "a.STL", of_upper_and_lower_case},
                         {"*.stl", "a.sTl", of_upper_and_lower_case},
                         {"[a-c]*.stl", "B.stl", of_upper_and_lower_case},
                         {"\xC3\xA4*.stl", "\xC3\x84x.stl", of_upper_and_lower_case},
                         {"*.stl", "a.stl ", of_blanks_at_ends},
                         {"*.stl", "a. stl", of_blanks_at_ends},
                         {"*.stl", "a.stl\xC2\xA0", of_blanks_at_ends},
                         {"*.stl", "a.STL ", of_blanks_at_ends | of_upper_and_lower_case},
                         {"parts ", "parts", of_blanks_at_ends},
                         {"*.stl", ".a.stl", of_leading_dot},
                         {"*.stl", "._A.STL", of_leading_dot | of_upper_and_lower_case},
                         {".*.stl", ".a.stl", 0U},
                         {"*.stl", "a.obj", std::nullopt},
                         {"*.stl", "a.stl.gz", std::nullopt},
                         {"a*.stl", "b.STL", std::nullopt},
                         {"*.stl", "x\xFF.STL", of_upper_and_lower_case}}) {
    CAPTURE(row.pattern);
    CAPTURE(row.name);
    CHECK(differences(std::string(row.pattern), std::string(row.name)) == row.differ);
  }
}

TEST_CASE("spelling: any folders of a path") {
  const Utf8Locale utf8;
  using List = std::vector<std::string>;
  const auto of = [](const List& parts, const List& names) { return differences(parts, names); };
  CHECK(of({"a", "**", "*.stl"}, {"a", "x.stl"}) == 0U);
  CHECK(of({"a", "**", "*.stl"}, {"a", "b", "c", "x.stl"}) == 0U);
  CHECK(of({"a", "**", "*.stl"}, {"A", "b", ".c", "x.stl"}) == (of_upper_and_lower_case | of_leading_dot));
  CHECK(of({"a", "**", "c", "*.stl"}, {"a", "b", "x.stl"}) == std::nullopt);
  CHECK(of({"a"}, {"a", "x.stl"}) == std::nullopt);
}

TEST_CASE("spelling: a pattern takes both cases of as few letters as needed") {
  const Utf8Locale utf8;
  using List = std::vector<std::string>;
  const auto both = [](const char* pattern, const List& paths) { return with_both_cases(pattern, paths); };
  CHECK(both("parts/*.stl", {"parts/A.STL", "parts/b.Stl"}) == "parts/*.[sS][tT][lL]");
  CHECK(both("parts/*.stl", {"parts/b.Stl"}) == "parts/*.[sS]tl");
  CHECK(both("parts/*.stl", {"Parts/b.stl"}) == "[pP]arts/*.stl");
  CHECK(both("v[a-c]/**/*.stl", {"vB/x/y.STL"}) == "v[a-cA-C]/**/*.[sS][tT][lL]");
  CHECK(both("\xC3\xA4*.stl", {"\xC3\x84x.stl"}) == "[\xC3\xA4\xC3\x84]*.stl");
  CHECK(both("*.stl", {"b.obj"}).empty());
}

TEST_CASE("spelling: a path that exists in another spelling") {
  const Folder folder;
  for (const char* file : {"Parts/BRACKET.STL", "trail /x.stl", "old\\flat.stl", "new/y.stl"}) folder.write(file, "x");
  const Inside inside(folder.path());
  Spellings spellings;
  CHECK(spelling_hint("parts/bracket.stl", spellings) == "; there is 'Parts/BRACKET.STL': upper and lower case count");
  CHECK(spelling_hint("trail/x.stl", spellings) == "; there is 'trail /x.stl': blanks at the ends of names count");
  CHECK(spelling_hint("new /y.stl", spellings) == "; there is 'new/y.stl': blanks at the ends of names count");
  CHECK(spelling_hint("new\\y.stl", spellings) == "; folders are separated by '/': there is 'new/y.stl'");
  CHECK(spelling_hint("new\\z.stl", spellings) == "; folders are separated by '/'");
  CHECK(spelling_hint("old/flat.stl", spellings) ==
        "; there is 'old\\flat.stl', with '\\' in its name: move it into its folder");
  CHECK(spelling_hint("new/z.stl", spellings).empty());
}
