#include "check/manifest/yaml_tree.h"

#include <algorithm>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge::check;
using Kind = YamlNode::Kind;

namespace {

YamlNode parsed(const std::string& text) {
  Mistakes mistakes;
  auto root = parse_yaml(text, mistakes);
  REQUIRE_MESSAGE(root.has_value(), text);
  CHECK(mistakes.empty());
  return *root;
}

std::string refusal(const std::string& text) {
  Mistakes mistakes;
  CHECK(!parse_yaml(text, mistakes));
  const auto all = std::move(mistakes).sorted();
  REQUIRE(all.size() == 1);
  return to_string("f", all[0]);
}

std::string repeated(const std::string& text, std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += text;
  return out;
}

}  // namespace

TEST_CASE("yaml: every node has its place") {
  const YamlNode root = parsed("\xEF\xBB\xBF# x\r\na: 'b'\r\n\xC3\xA4: [c, {}]\r\nd:\r\n");
  REQUIRE(root.kind == Kind::map);
  REQUIRE(root.keys.size() == 3);
  CHECK(root.keys[0].text == "a");
  CHECK(root.keys[0].place.line == 2);
  CHECK(root.items[0].kind == Kind::quoted);
  CHECK(root.items[0].place.column == 4);
  REQUIRE(root.items[1].kind == Kind::list);
  CHECK(root.items[1].place.column == 4);  // in characters, not in bytes
  CHECK(root.items[1].items[0].kind == Kind::word);
  CHECK(root.items[1].items[1].kind == Kind::map);
  CHECK(root.items[2].kind == Kind::none);
  CHECK(root.items[2].place.line == 4);  // of its key
}

TEST_CASE("yaml: an empty file holds nothing") {
  for (const char* text : {"", "\n", "# only words\n", "---\n", "...\n", "~"}) CHECK(parsed(text).kind == Kind::none);
}

TEST_CASE("yaml: a duplicate key is a mistake and does not hide others") {
  Mistakes mistakes;
  CHECK(parse_yaml("a: 1\nb: {c: 1, c: 2}\na: 2\n", mistakes));
  const auto all = std::move(mistakes).sorted();
  REQUIRE(all.size() == 2);
  CHECK(to_string("f", all[0]) == "f:2:11: the key 'c' stands twice, first in line 2: leave one of the two out");
  CHECK(to_string("f", all[1]) == "f:3:1: the key 'a' stands twice, first in line 1: leave one of the two out");
}

TEST_CASE("yaml: aliases are refused") {
  std::string bomb = "a0: &a0 [x, x]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string n = std::to_string(i), last = std::to_string(i - 1);
    bomb += "a" + n + ": &a" + n + " [*a" + last + ", *a" + last + "]\n";
  }
  CHECK(refusal(bomb).find("f:2:10: '*' begins an alias in YAML, and aliases are not taken") == 0);
}

TEST_CASE("yaml: depth, size and number are limited") {
  CHECK(parsed(repeated("[", kMaxYamlDepth) + repeated("]", kMaxYamlDepth)).kind == Kind::list);
  const std::size_t deep = 50'000;
  for (const std::string& text : {repeated("[", deep) + repeated("]", deep),
                                  repeated("{a: ", deep) + repeated("}", deep), repeated("- ", deep)}) {
    CHECK(refusal(text).find("nested deeper than 16 levels") != std::string::npos);
  }
  for (const char* opened : {"[", "{a: ", "? ", "{["}) CHECK(refusal(repeated(opened, deep)).find("f:1:") == 0);
  CHECK(refusal(repeated("#", kMaxYamlBytes + 1)) == "f: larger than 1048576 bytes");
  CHECK(parsed(repeated("#", kMaxYamlBytes)).kind == Kind::none);
  CHECK(parsed("[" + repeated("a,", kMaxYamlNodes - 1) + "]").items.size() == kMaxYamlNodes - 1);
  CHECK(refusal("[" + repeated("a,", kMaxYamlNodes) + "]").find("more than 100000 values") != std::string::npos);
}

TEST_CASE("yaml: a quote that is never closed is seen in a file cut anywhere") {
  const std::string text = "a: \"b\"\nc: 'd'\n";
  for (std::size_t length = 0; length < text.size(); ++length) {
    const std::string cut = text.substr(0, length);
    CAPTURE(cut);
    const auto count = [&](char quote) { return std::count(cut.begin(), cut.end(), quote); };
    Mistakes mistakes;
    const bool read = parse_yaml(cut, mistakes).has_value();
    if (count('"') % 2 == 1 || count('\'') % 2 == 1) CHECK(!read);
  }
  CHECK(refusal("a: \"b\nc: d\n").find("a quote is opened before this line and not closed") != std::string::npos);
}

TEST_CASE("yaml: one document, and nothing but UTF-8") {
  CHECK(refusal("a: 1\n---\nb: 2\n").find("f:2:1: one document ends before this line") == 0);
  CHECK(refusal("{a: 1},").find("f:1:") == 0);  // yaml-cpp would go round in circles
  CHECK(refusal("- a\nb: 3\n").find("f:2:1: one document ends before this line") == 0);
  CHECK(refusal("a: \xFF") == "f:1:4: not UTF-8: save the file in this encoding");
  CHECK(refusal(std::string("a: 1\nb: \0", 9)) ==
        "f:2:4: a control character: remove it, or write it as an escape in double quotes");
  CHECK(refusal(std::string("\xFF\xFE"
                            "a\0",
                            4))
            .find("not UTF-8") != std::string::npos);
}
