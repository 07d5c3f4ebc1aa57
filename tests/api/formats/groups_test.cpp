#include "api/formats/groups.h"

#include <string>

#include <doctest/doctest.h>

#include "api/formats/read_part.h"
#include "tests/api/formats/gltf_files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

const std::string kCorners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 0\n";
const std::string kFace = "f 1 2 3\n";

std::string shown(const Groups& groups) {
  std::string text = groups.too_many ? "too many" : "";
  for (const Group& group : groups.named) {
    text += (text.empty() ? "" : ", ") + group.name;
    for (const TriangleRange& range : group.ranges)
      text += " " + std::to_string(range.first) + "-" + std::to_string(range.end);
  }
  return text;
}

std::string groups_of(const std::string& file, const char* name) {
  const auto result = read(file, name);
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(is_valid(result->groups, result->mesh.triangles.size()));
  return shown(result->groups);
}

std::string groups_of_obj(const std::string& text) { return groups_of(kCorners + text, "m.obj"); }

}  // namespace

TEST_CASE("groups: of an OBJ, by g and o") {
  CHECK(groups_of_obj(kFace) == "");
  CHECK(groups_of_obj("g a\n" + kFace + "g b\n" + kFace + kFace) == "a 0-1, b 1-3");
  CHECK(groups_of_obj(kFace + "g b\n" + kFace + "g\n" + kFace) == "b 1-2");
  CHECK(groups_of_obj("g a b\n" + kFace + "g b\n" + kFace + "g a\n" + kFace) == "a 0-1 2-3, b 0-2");
  CHECK(groups_of_obj("g a a\n" + kFace + "g a\n" + kFace) == "a 0-2");
  CHECK(groups_of_obj("g a \\\n b\r\n" + kFace + "g b\\\n\n" + kFace) == "a 0-1, b 0-2");
  CHECK(groups_of_obj("g\ta\t\n" + kFace) == "a 0-1");
  CHECK(groups_of_obj("o the part \n" + kFace + "g a\n" + kFace + "o b\n" + kFace) == "a 1-3, b 2-3, the part 0-2");
  CHECK(groups_of_obj("o a\n" + kFace + "g a\n" + kFace + "g c\n" + kFace) == "a 0-3, c 2-3");
  CHECK(groups_of_obj("g none\ng a\n" + kFace) == "a 0-1");
  CHECK(groups_of_obj("group a\nobject b\n" + kFace) == "");
}

TEST_CASE("groups: a word that begins with # ends the names of a line") {
  CHECK(groups_of_obj("g Y # like X\n" + kFace) == "Y 0-1");
  CHECK(groups_of_obj("g #Y\n" + kFace) == "");
  CHECK(groups_of_obj("g Y#1 X\n" + kFace) == "X 0-1, Y#1 0-1");
  CHECK(groups_of_obj("o the part \t# like X\n" + kFace) == "the part 0-1");
  CHECK(groups_of_obj("o #X\n" + kFace) == "");
  CHECK(groups_of_obj("o part #\n" + kFace) == "part 0-1");
  CHECK(groups_of_obj("o part#1 a\n" + kFace) == "part#1 a 0-1");
  CHECK(groups_of_obj("g Y # \\\n" + kFace + "o X # \\\n" + kFace) == "X 1-2, Y 0-2");  // as after a vertex
  CHECK(contains(refusal(kCorners + std::string("o a # \0\n", 8) + kFace, "m.obj"), "line 6 of 'a': binary data"));
}

TEST_CASE("groups: of polygons, of faces without a triangle, of degenerate triangles") {
  CHECK(groups_of_obj("g a\nf 1 2 5 3\ng b\nf 1 2\nf 1 1 1\ng c\nf 1 2 5 3\n") == "a 0-2, b 2-3, c 3-5");
}

TEST_CASE("groups: a name is UTF-8 on one line, of at most 256 bytes") {
  CHECK(groups_of_obj("g Bohrung-\xC3\xA4\n" + kFace) == "Bohrung-\xC3\xA4 0-1");
  CHECK(groups_of_obj("g \xE4 a\n" + kFace) == "a 0-1");
  CHECK(groups_of_obj("g \x01 a\n" + kFace) == "a 0-1");
  CHECK(groups_of_obj("g a\xC2\x9B"
                      "31m \xE2\x80\xAE"
                      "b \xEF\xBB\xBF"
                      "c d\n" +
                      kFace) == "d 0-1");  // not shown raw
  CHECK(groups_of_obj("g " + std::string(256, 'x') + "\n" + kFace) == std::string(256, 'x') + " 0-1");
  CHECK(groups_of_obj("g " + std::string(257, 'x') + "\n" + kFace) == "");
  CHECK(contains(refusal(kCorners + std::string("g a\0b\n", 6) + kFace, "m.obj"), "line 6 of 'a': binary data"));
  CHECK(contains(refusal(kCorners + std::string("o a\0b\n", 6) + kFace, "m.obj"), "line 6 of 'a': binary data"));
}

TEST_CASE("groups: more than are kept leave none, and the mesh as it is") {
  std::string ranges, names;
  for (std::size_t i = 0; i <= kMostGroupRanges / 2; ++i) ranges += "g a\n" + kFace + "g b\n" + kFace;
  for (std::size_t i = 0; i <= kMostBytesOfGroups / 250; ++i)
    names += "g " + std::to_string(i) + std::string(250, 'x') + "\n" + kFace;
  CHECK(groups_of_obj(ranges) == "too many");
  CHECK(groups_of_obj(names) == "too many");
  CHECK(groups_of_obj("g a\n" + kFace + names.substr(0, names.size() / 2)).starts_with("0xxx"));
}

TEST_CASE("groups: a line of more names than are kept") {
  std::string names = "g";
  for (std::size_t i = 0; i < kMostGroupRanges; ++i) names += " a";
  CHECK(groups_of_obj(names + "\n" + kFace) == "a 0-1");
  CHECK(groups_of_obj(names + " a\n" + kFace) == "too many");
  CHECK(groups_of_obj(names + " a \\\n a\ng b\n" + kFace) == "too many");
}

TEST_CASE("groups: the triangles of a welded mesh keep their order") {
  std::string text;
  for (const char* name : {"a", "b"}) text += std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\ng ") + name + "\nf -3 -2 -1\n";
  const auto result = read_part(bytes_of(text), {"a", "m.obj", ""}, {});
  REQUIRE(result.ok());
  CHECK(result->notes.welded_vertices == 3);
  CHECK(shown(result->groups) == "a 0-1, b 1-2");
}

TEST_CASE("groups: nodes of a glTF, each with those below it") {
  json document = tetrahedron();
  document["nodes"] = {{{"name", "assembly"}, {"children", {1, 2, 3}}},
                       {{"name", "left"}, {"mesh", 0}},
                       {{"name", "right"}, {"mesh", 0}, {"children", {4}}},
                       {{"mesh", 0}},
                       {{"name", "left"}, {"mesh", 0}}};
  document["scenes"][0]["nodes"] = {0};
  CHECK(groups_of(glb(document), "m.glb") == "assembly 0-16, left 0-4 8-12, right 4-12");
  document["nodes"][1]["name"] = 7;  // was never looked at
  document["nodes"][2]["name"] = "a\nb";
  CHECK(groups_of(glb(document), "m.glb") == "assembly 0-16, left 8-12");
}

TEST_CASE("groups: a node above one of its own name") {
  json document = tetrahedron();
  document["nodes"] = {{{"name", "x"}, {"mesh", 0}, {"children", {1}}}, {{"name", "x"}, {"mesh", 0}}};
  document["scenes"][0]["nodes"] = {0};
  CHECK(groups_of(glb(document), "m.glb") == "x 0-8");
  document["nodes"] = {{{"name", "x"}, {"children", {1, 2, 3}}},
                       {{"name", "x"}, {"mesh", 0}},
                       {{"name", "y"}, {"mesh", 0}},
                       {{"name", "x"}, {"mesh", 0}}};
  CHECK(groups_of(glb(document), "m.glb") == "x 0-12, y 4-8");
}

TEST_CASE("groups: nodes of one name in one another are one run of triangles") {
  GroupCollector collector;
  const std::size_t depth = kMostGroupRanges + 2;
  for (std::size_t i = 0; i < depth; ++i) collector.add("x", depth - i, depth + 1);
  CHECK(shown(collector.take()) == "x 1-" + std::to_string(depth + 1));
}

TEST_CASE("groups: objects of a 3MF, wherever the build places them") {
  const auto named = [](std::string object, const std::string& name) {
    return object.insert(object.find(" id="), " name=\"" + name + "\"");
  };
  const std::string both = "<components><component objectid=\"1\"/><component objectid=\"2\"/></components>";
  const std::string resources = named(triangle_object(1), "lid") + named(triangle_object(2), "foot &amp; toe") +
                                "<object id=\"3\" name=\"all\">" + both + "</object>";
  const std::string build = "<item objectid=\"3\"/><item objectid=\"1\"/>";
  CHECK(groups_of(package(model(resources, build)), "m.3mf") == "all 0-2, foot & toe 1-2, lid 0-1 2-3");
}

TEST_CASE("groups: what a reader does not make is not valid") {
  const auto valid = [](const std::vector<Group>& named) { return is_valid(Groups{named}, 10); };
  CHECK(valid({}));
  CHECK(valid({{"a", {{0, 3}, {5, 10}}}, {"b", {{0, 3}}}}));
  CHECK(!valid({{"a", {}}}));
  CHECK(!valid({{"a", {{3, 3}}}}));
  CHECK(!valid({{"a", {{3, 2}}}}));
  CHECK(!valid({{"a", {{3, 11}}}}));
  CHECK(!valid({{"a", {{3, 5}, {4, 6}}}}));
  CHECK(!valid({{"a", {{3, 5}, {1, 2}}}}));
  CHECK(!valid({{"b", {{0, 3}}}, {"a", {{0, 3}}}}));
  CHECK(!valid({{"", {{0, 3}}}}));
  CHECK(!valid({{"\xFF", {{0, 3}}}}));
}

}  // namespace meshgauge::api::test
