// No surface is lost in silence: a file with one face-bearing element less than another reads differently.
#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_documents.h"
#include "tests/api/formats/zip_files.h"
#include "tests/fuzz/dice.h"
#include "tests/today.h"

namespace meshgauge::api::test {
namespace {

using fuzz::Dice;

constexpr std::uint64_t kFiles = 1000;  // a quarter of them each day

// A file made of parts, of which those that bear faces can be left out one by one.
struct Part {
  std::string text;
  bool bears_faces = false;
};
using Parts = std::vector<Part>;

// What a user can see of how much of the surface was read.
struct Seen {
  bool refused = false;
  std::size_t triangles = 0;
  std::size_t skipped = 0, unused = 0, helpers = 0;
  std::vector<std::string> remarks;

  bool operator==(const Seen&) const = default;
};

Seen seen(const std::string& file, const std::string& name) {
  const auto result = read(file, name);
  if (!result) return {true, 0, 0, 0, 0, {}};
  const ReadNotes& notes = result->notes;
  return {false,
          notes.cloud ? 0 : result->mesh.triangles.size(),
          notes.skipped_primitives + (notes.cloud ? result->mesh.positions.size() : 0),
          notes.unused_objects,
          notes.helper_objects,
          notes.remarks};
}

// Checks today's files, each without any one of its face-bearing parts. `assemble` makes a file of parts.
void check_dropping(const std::string& name, const std::function<Parts(Dice&)>& generate,
                    const std::function<std::string(const Parts&)>& assemble) {
  std::size_t dropped = 0;
  for (const std::uint64_t seed : todays_part(kFiles, 4)) {
    Dice dice(seed);
    const Parts parts = generate(dice);
    const std::string file = assemble(parts);
    INFO(name << ", seed " << seed << ": " << refusal(file, name));
    const Seen whole = seen(file, name);
    REQUIRE_FALSE(whole.refused);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (!parts[i].bears_faces) continue;
      Parts rest = parts;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
      INFO("without " << parts[i].text);
      CHECK(seen(assemble(rest), name) != whole);
      ++dropped;
    }
  }
  CHECK(dropped >= kFiles / 4);
}

std::string joined(const Parts& parts) {
  std::string out;
  for (const Part& part : parts) out += part.text;
  return out;
}

// Three to seven parts, each by `one`, after a first one that bears faces.
Parts some(Dice& dice, const std::function<Part(Dice&)>& face, const std::function<Part(Dice&)>& one) {
  Parts parts{face(dice)};
  for (int count = dice.between(2, 6); count > 0; --count) parts.push_back(one(dice));
  return parts;
}

std::string indices(Dice& dice, int count, int first, const std::string& behind = "") {
  std::string out;
  const int start = dice.between(0, 7);
  for (int i = 0; i < count; ++i) out += " " + std::to_string(first + (start + i) % 8) + behind;
  return out;
}

const std::string kCube = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n";

// --- OBJ ------------------------------------------------------------------------------------------------------------

Part obj_face(Dice& dice) {
  const int corners = dice.between(3, 5);
  switch (dice.below(6)) {
    case 0:
      return {"f" + indices(dice, corners, 1, "/1") + "\n", true};
    case 1:
      return {"f" + indices(dice, corners, 1, "//1") + " # face\r\n", true};
    case 2:
      return {"f" + indices(dice, corners, -8) + "\n", true};
    case 3:
      return {"fo" + indices(dice, corners, 1) + "\n", true};
    case 4:
      return {"f \\\n" + indices(dice, corners, 1) + " \\\n\n", true};
    default:
      return {"f" + indices(dice, corners, 1) + "\n", true};
  }
}

Part obj_statement(Dice& dice) {
  const std::string patch = "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nparm u 0 1\nparm v 0 1\nend\n";
  const Part kinds[] = {{"# comment\n"}, {"g a b\n"},   {"o part\n"},  {"usemtl m\n"},          {"vn 0 0 1\n"},
                        {"s off\n"},     {"l 1 2 3\n"}, {patch, true}, {"bzp 1 2 3 4\n", true}, {"cdp 1 2 3 4\n", true},
                        {"p 1\n"}};
  return dice.chance(0.5) ? obj_face(dice) : dice.pick(kinds);
}

TEST_CASE("dropping: OBJ") {
  std::string vertices;
  for (std::size_t at = 0; at < kCube.size(); at += 6) vertices += "v " + kCube.substr(at, 6);
  check_dropping(
      "m.obj", [](Dice& dice) { return some(dice, obj_face, obj_statement); },
      [&](const Parts& parts) { return vertices + "vt 0 0\nvn 0 0 1\n" + joined(parts); });
}

// --- STL ------------------------------------------------------------------------------------------------------------

Part ascii_facet(Dice& dice) {
  std::string text = "facet normal 0 0 1\nouter loop\n";
  for (int corner = 0; corner < 3; ++corner) {
    text += "vertex " + std::to_string(dice.between(0, 9)) + " " + std::to_string(dice.between(0, 9)) + " 1e-1\n";
  }
  return {text + "endloop\nendfacet\n", true};
}

TEST_CASE("dropping: STL of text") {
  check_dropping(
      "m.stl",
      [](Dice& dice) {
        return some(dice, ascii_facet,
                    [](Dice& one) { return one.chance(0.8) ? ascii_facet(one) : Part{"endsolid a\nsolid b\n"}; });
      },
      [](const Parts& parts) { return "solid a\n" + joined(parts) + "endsolid\n"; });
}

Part binary_facet(Dice& dice) {
  std::string text;
  for (int k = 0; k < 12; ++k) text += raw(static_cast<float>(dice.uniform(-9, 9)));
  return {text + std::string(2, dice.chance(0.5) ? '\0' : '\x7F'), true};
}

std::string binary_stl(const Parts& parts, std::size_t count) {
  return std::string(80, 'x') + raw(static_cast<std::uint32_t>(count)) + joined(parts);
}

TEST_CASE("dropping: binary STL, with its count and without") {
  const auto facets = [](Dice& dice) { return some(dice, binary_facet, binary_facet); };
  check_dropping("m.stl", facets, [](const Parts& parts) { return binary_stl(parts, parts.size()); });
  std::size_t announced = 0;
  check_dropping(
      "m.stl",
      [&](Dice& dice) {
        Parts parts = facets(dice);
        announced = parts.size();
        return parts;
      },
      [&](const Parts& parts) { return binary_stl(parts, announced); });
}

TEST_CASE("dropping: a binary STL whose count is too small by whole facets is not read as a smaller one") {
  for (const std::uint64_t seed : todays_part(kFiles, 4)) {
    Dice dice(seed);
    const Parts parts = some(dice, binary_facet, binary_facet);
    const std::size_t missing = 1 + dice.below(static_cast<std::uint32_t>(parts.size()));
    const auto result = read(binary_stl(parts, parts.size() - missing), "m.stl");
    INFO("seed " << seed << ", " << missing << " of " << parts.size() << " missing");
    CHECK((!result || result->mesh.triangles.size() == parts.size()));
  }
}

// --- PLY and OFF ----------------------------------------------------------------------------------------------------

Part counted_face(Dice& dice) {
  const int corners = dice.between(3, 5);
  return {std::to_string(corners) + indices(dice, corners, 0) + "\n", true};
}

TEST_CASE("dropping: PLY of faces") {
  check_dropping(
      "m.ply", [](Dice& dice) { return some(dice, counted_face, counted_face); },
      [](const Parts& parts) {
        return "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
               "element face " +
               std::to_string(parts.size()) + "\nproperty list uchar int vertex_indices\nend_header\n" + kCube +
               joined(parts);
      });
}

TEST_CASE("dropping: PLY of strips") {
  check_dropping(
      "m.ply", [](Dice& dice) { return some(dice, counted_face, counted_face); },
      [](const Parts& parts) {
        return "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
               "element tristrips " +
               std::to_string(parts.size()) + "\nproperty list int int vertex_indices\nend_header\n" + kCube +
               joined(parts);
      });
}

// Each part is an element of the file: its name, and after a blank its records. Names after the first occur once.
TEST_CASE("dropping: PLY of elements, some of which are not read") {
  const auto element = [](Dice& dice, const std::string& name) {
    const bool is_strip = name == "tristrips";
    return Part{name + " " + counted_face(dice).text + (is_strip ? "" : counted_face(dice).text), true};
  };
  check_dropping(
      "m.ply",
      [&](Dice& dice) {
        Parts parts{element(dice, "face")};
        for (const char* name : {"tristrips", "polygon", "triangle_fan", "patches", "cells"}) {
          if (dice.chance(0.6)) parts.push_back(element(dice, name));
        }
        if (parts.size() == 1) parts.push_back(element(dice, "quads"));
        return parts;
      },
      [](const Parts& parts) {
        std::string header, records;
        for (const Part& part : parts) {
          const std::size_t blank = part.text.find(' ');
          const std::string rows = part.text.substr(blank + 1);
          header += "element " + part.text.substr(0, blank) + " " + std::to_string(std::ranges::count(rows, '\n')) +
                    "\nproperty list int int vertex_indices\n";
          records += rows;
        }
        return "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n" +
               header + "end_header\n" + kCube + records;
      });
}

TEST_CASE("dropping: OFF") {
  check_dropping(
      "m.off",
      [](Dice& dice) {
        return some(dice, counted_face, [](Dice& one) { return one.chance(0.8) ? counted_face(one) : Part{"# c\n"}; });
      },
      [](const Parts& parts) {
        const auto faces = std::ranges::count_if(parts, [](const Part& part) { return part.bears_faces; });
        return "OFF\n8 " + std::to_string(faces) + " 0\n" + kCube + joined(parts);
      });
}

// --- XYZ ------------------------------------------------------------------------------------------------------------

TEST_CASE("dropping: XYZ, whose points are its surface") {
  const auto point = [](Dice& dice) {
    return Part{std::to_string(dice.between(0, 9)) + " 1 " + std::to_string(dice.between(0, 9)) + "\n", true};
  };
  check_dropping(
      "m.xyz",
      [&](Dice& dice) {
        return some(dice, point, [&](Dice& one) { return one.chance(0.8) ? point(one) : Part{"# c\n"}; });
      },
      joined);
}

// --- glTF -----------------------------------------------------------------------------------------------------------

Part primitive(Dice& dice) {
  json one = {{"attributes", {{"POSITION", 0}}}, {"mode", dice.between(4, 6)}};
  if (dice.chance(0.5)) one["indices"] = 1;
  if (dice.chance(0.2)) one["extensions"]["EXT_" + std::to_string(dice.between(0, 3))] = json::object();
  return {one.dump(), true};
}

// A primitive whose surface is in an extension alone.
Part foreign_primitive(Dice& dice) {
  const char* const names[] = {"EXT_primitive_voxels", "KHR_gaussian_splatting", "ACME_patches"};
  json one = {{"attributes", {{"NORMAL", 0}}}, {"extensions", {{dice.pick(names), json::object()}}}};
  return {one.dump(), true};
}

// Each part is a primitive; two neighbours share a mesh, and each mesh a node of its own.
json scene_of(const Parts& parts) {
  json document = tetrahedron();
  document["meshes"] = document["nodes"] = json::array();
  document["scenes"][0]["nodes"] = json::array();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (i % 2 == 0) {
      document["scenes"][0]["nodes"].push_back(document["nodes"].size());
      document["nodes"].push_back({{"mesh", document["meshes"].size()}});
      document["meshes"].push_back({{"primitives", json::array()}});
    }
    document["meshes"].back()["primitives"].push_back(json::parse(parts[i].text));
  }
  return document;
}

TEST_CASE("dropping: glTF, a primitive") {
  check_dropping(
      "m.glb",
      [](Dice& dice) {
        return some(dice, primitive,
                    [](Dice& one) { return one.chance(0.7) ? primitive(one) : foreign_primitive(one); });
      },
      [](const Parts& parts) { return glb(scene_of(parts)); });
}

// Each part is a node; its mesh stays in the file.
TEST_CASE("dropping: glTF, a node") {
  const auto node = [](Dice& dice) {
    json one = {{"mesh", dice.between(0, 2)}, {"translation", {dice.between(0, 9), 0, 1}}};
    return Part{one.dump(), true};
  };
  check_dropping(
      "m.glb", [&](Dice& dice) { return some(dice, node, node); },
      [](const Parts& parts) {
        Parts meshes;
        for (const int mode : {4, 5, 6}) {
          meshes.push_back({json{{"attributes", {{"POSITION", 0}}}, {"indices", 1}, {"mode", mode}}.dump()});
          meshes.push_back(meshes.back());
        }
        json document = scene_of(meshes);
        document["nodes"] = document["scenes"][0]["nodes"] = json::array();
        for (const Part& part : parts) {
          document["scenes"][0]["nodes"].push_back(document["nodes"].size());
          document["nodes"].push_back(json::parse(part.text));
        }
        return glb(document);
      });
}

// --- 3MF ------------------------------------------------------------------------------------------------------------

const std::string kTetrahedron =
    "<vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" y=\"1\" z=\"0\"/>"
    "<vertex x=\"0\" y=\"0\" z=\"1\"/>";

Part xml_triangle(Dice& dice) {
  const int start = dice.between(0, 3);
  std::string text = "<triangle";
  for (int k = 0; k < 3; ++k) {
    text += " v" + std::to_string(k + 1) + "=\"" + std::to_string((start + k) % 4) + "\"";
  }
  return {text + (dice.chance(0.5) ? "/>" : " pid=\"9\"></triangle>"), true};
}

// An element among the triangles that 3MF does not have: of a vendor, or with a prefix that is not declared.
Part foreign_triangle(Dice& dice) {
  const char* const names[] = {"x:curved", "y:quad", "x:triangle"};
  return {"<" + std::string(dice.pick(names)) + " xmlns:x=\"urn:x\" v1=\"0\" v2=\"1\" v3=\"3\"/>", true};
}

TEST_CASE("dropping: 3MF, a triangle") {
  check_dropping(
      "m.3mf",
      [](Dice& dice) {
        return some(dice, xml_triangle,
                    [](Dice& one) { return one.chance(0.7) ? xml_triangle(one) : foreign_triangle(one); });
      },
      [](const Parts& parts) {
        return package(model("<object id=\"1\"><mesh><vertices>" + kTetrahedron + "</vertices><triangles>" +
                                 joined(parts) + "</triangles></mesh></object>",
                             "<item objectid=\"1\"/>"));
      });
}

TEST_CASE("dropping: 3MF, a component and an item") {
  const auto placed = [](Dice& dice) {
    const std::string id = std::to_string(dice.between(1, 2));
    return Part{dice.chance(0.5) ? "<component objectid=\"" + id + "\"/>" : "<item objectid=\"" + id + "\"/>", true};
  };
  check_dropping(
      "m.3mf", [&](Dice& dice) { return some(dice, placed, placed); },
      [](const Parts& parts) {
        std::string components, items;
        for (const Part& part : parts) (part.text.starts_with("<item") ? items : components) += part.text;
        if (!components.empty()) {
          components = "<object id=\"3\"><components>" + components + "</components></object>";
          items += "<item objectid=\"3\"/>";
        }
        return package(model(triangle_object(1) + triangle_object(2) + components, items));
      });
}

}  // namespace
}  // namespace meshgauge::api::test
