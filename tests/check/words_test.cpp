#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include "api/base/suggestion.h"
#include "api/base/utf8.h"
#include "check/manifest/mistake.h"
#include "check/manifest/naming.h"

using namespace meshgauge::check;
using meshgauge::api::suggestion;

TEST_CASE("suggestion: the nearest word is suggested") {
  constexpr std::string_view kKnown[] = {"name", "max_distance", "timeout", "on_fail"};
  for (const char* word :
       {"max_distnace", "max_distanc", "maxdistance", "Max-Distance", "max distance", "mx_distance", "max_dist"}) {
    CAPTURE(word);
    CHECK(suggestion(word, kKnown) == "; did you mean 'max_distance'?");
  }
  CHECK(suggestion("nmae", kKnown) == "; did you mean 'name'?");
  CHECK(suggestion("timeout_ms", kKnown) == "; did you mean 'timeout'?");
  CHECK(suggestion("colour", kKnown) == "; known: name, max_distance, timeout, on_fail");
  CHECK(suggestion("", kKnown) == "; known: name, max_distance, timeout, on_fail");
  CHECK(suggestion(std::string(1 << 20, 'x'), kKnown) == "; known: name, max_distance, timeout, on_fail");
}

TEST_CASE("naming: placeholders are filled in from the candidate") {
  const NameParts parts = name_parts("part.v2.stl.GZ", "near/by");
  CHECK(parts.stem == "part.v2");
  CHECK(filled("lod-{stem}", parts) == "lod-part.v2");
  CHECK(filled("{dir}/{name}", parts) == "near/by/part.v2.stl.GZ");
  CHECK(filled("{stem}{stem}", parts) == "part.v2part.v2");
  CHECK(filled("plain", parts) == "plain");
}

TEST_CASE("naming: no folder leaves no slash") {
  const NameParts parts = name_parts("part.stl", "");
  CHECK(parts.stem == "part");
  CHECK(filled("baselines/{dir}/{name}", parts) == "baselines/part.stl");
  CHECK(filled("{dir}/{stem}", parts) == "part");
  CHECK(filled("{dir}", parts) == ".");
  CHECK(filled("{dir}-{stem}", parts) == ".-part");
  CHECK(filled("{dir}{stem}", parts) == ".part");
}

TEST_CASE("naming: files with an unusual name have a stem") {
  CHECK(name_parts("part", "").stem == "part");
  CHECK(name_parts(".stl", "").stem == ".stl");
  CHECK(name_parts("part.gz", "").stem == "part");
  CHECK(name_parts("{stem}.stl", "").stem == "{stem}");
  CHECK(filled("{stem}", name_parts("{name}.stl", "")) == "{name}");  // filled in once
}

TEST_CASE("naming: braces hold placeholders and nothing else") {
  for (const char* text : {"", "x", "{stem}", "{dir}/{name}{stem}"}) CHECK(check_template(text).ok());
  for (const char* text : {"{", "}", "{stem", "stem}", "{{stem}}", "{stem}}", "}{", "{stem{name}"}) {
    CAPTURE(text);
    REQUIRE(!check_template(text).ok());
    CHECK(check_template(text).error().message.find("brace without its partner") != std::string::npos);
  }
  CHECK(check_template("{}").error().message == "has an unknown placeholder '{}'; known: stem, name, dir");
  CHECK(check_template("{nmae}").error().message == "has an unknown placeholder '{nmae}'; did you mean 'name'?");
}

TEST_CASE("utf8: only well-formed UTF-8 of RFC 3629 is accepted") {
  for (const char* good :
       {"", "abc", "\xC3\xA4", "\xE2\x82\xAC", "\xF0\x9F\x98\x80", "\xEE\x80\x80", "\xF4\x8F\xBF\xBF"})
    CHECK(meshgauge::is_utf8(good));
  struct Row {
    const char* text;
    std::size_t where;
  };
  for (const Row& row : {Row{"ab\xFF", 2},
                         {"\x80", 0},
                         {"\xC3", 0},
                         {"x\xC0\x80", 1},
                         {"\xE0\x80\x80", 0},
                         {"\xED\xA0\x80", 0},
                         {"\xF4\x90\x80\x80", 0},
                         {"\xF8\x88\x80\x80\x80", 0},
                         {"\xC3\xA4\xC3", 2},
                         {"\xE2\x82", 0}}) {
    CHECK(meshgauge::find_not_utf8(row.text) == row.where);
  }
}

TEST_CASE("mistakes: sorted, each once, limited in number") {
  Mistakes mistakes;
  mistakes.add({2, 1}, "b");
  mistakes.add({}, "whole");
  mistakes.add({1, 9}, "a");
  mistakes.add({2, 1}, "b");
  const auto sorted = std::move(mistakes).sorted();
  REQUIRE(sorted.size() == 3);
  CHECK(to_string("gates.yaml", sorted[0]) == "gates.yaml: whole");
  CHECK(to_string("gates.yaml", sorted[1]) == "gates.yaml:1:9: a");
  CHECK(to_string("gates.yaml", sorted[2]) == "gates.yaml:2:1: b");

  Mistakes many;
  for (int i = 0; i < 250; ++i) many.add({i + 1, 1}, "x");
  const auto some = std::move(many).sorted();
  REQUIRE(some.size() == Mistakes::kMost + 1);
  CHECK(to_string("f", some.back()) == "f: and 150 more mistakes");
}
