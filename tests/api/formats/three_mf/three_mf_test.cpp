#include "api/formats/file/readers.h"

#include <cstdlib>

#include "tests/api/formats/three_mf_files.h"

namespace meshgauge::api::test {
namespace {

const std::string kIdentity = "1 0 0 0 1 0 0 0 1 0 0 0";

std::vector<Vec3> placed(const std::string& resources, const std::string& build, const std::string& attributes = "") {
  return good_3mf(package(model(resources, build, attributes))).mesh.positions;
}

std::string refused_3mf(const std::string& resources, const std::string& build = kItem,
                        const std::string& attributes = "") {
  return refusal(package(model(resources, build, attributes)), "m.3mf");
}

std::string item(int object, const std::string& transform) {
  return "<item objectid=\"" + std::to_string(object) + "\" transform=\"" + transform + "\"/>";
}

std::string component(int object, const std::string& more = "") {
  return "<component objectid=\"" + std::to_string(object) + "\" " + more + "/>";
}

std::string assembly(int id, const std::string& components) {
  return "<object id=\"" + std::to_string(id) + "\"><components>" + components + "</components></object>";
}

// The triangle of triangle_object() with its first vertex or its one triangle replaced.
std::string with_vertex(const std::string& attributes) {
  std::string object = triangle_object(1);
  return object.replace(object.find("x=\"0\" y=\"0\" z=\"0\""), 17, attributes);
}
std::string with_triangle(const std::string& attributes) {
  std::string object = triangle_object(1);
  return object.replace(object.find("v1=\"0\" v2=\"1\" v3=\"2\""), 20, attributes);
}

const std::vector<Vec3> kTriangle = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

}  // namespace

TEST_CASE("3mf: coordinates are bit-equal to strtod") {
  for (const char* number : {"0.1", "-2.5E+1", "1e-3", ".5", "+7", " 3 ", "0.30000000000000004", "-0", "4.9e-324",
                             "123456789012345678901234567890", "0.1234567890123456789"}) {
    const auto positions = placed(with_vertex("z=\"" + std::string(number) + "\" x=\"1\" y=\"2\""), kItem);
    CAPTURE(number);
    CHECK(raw(positions[0].z()) == raw(std::strtod(number, nullptr)));
    CHECK(positions[0].x() == 1);
  }
}

TEST_CASE("3mf: the build places objects, with transforms and more than once") {
  const ReadMesh one = good_3mf(package(model(triangle_object(1), kItem)));
  CHECK(one.mesh.positions == kTriangle);
  CHECK(one.mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
  CHECK(placed(triangle_object(1), item(1, "1 0 0 0 1 0 0 0 1 0 0 0")) == kTriangle);
  // Row vectors: x goes to (0 2 0), y to (-2 0 0), z to (0 0 2); then moved by (5 6 7).
  const auto turned = placed(triangle_object(1), item(1, " 0 2 0  -2 0 0\n0 0 2 5 6 7 "));
  CHECK(turned == std::vector<Vec3>{{5, 6, 7}, {5, 8, 7}, {3, 6, 7}});
  const ReadMesh two = good_3mf(package(model(triangle_object(1), kItem + item(1, "-1 0 0 0 1 0 0 0 1 10 0 0"))));
  CHECK(two.mesh.triangles == std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}});
  CHECK(two.mesh.positions[4] == Vec3(9, 0, 0));
}

TEST_CASE("3mf: components, nested and instanced, before or after what they use") {
  const std::string shift = "transform=\"1 0 0 0 1 0 0 0 1 1 0 0\"";
  const std::string doubled = "transform=\"2 0 0 0 2 0 0 0 2 0 0 0\"";
  const std::string resources =
      assembly(3, component(2, doubled)) + assembly(2, component(1, shift) + component(1)) + triangle_object(1);
  const auto positions = placed(resources, item(3, "1 0 0 0 1 0 0 0 1 0 0 100"));
  CHECK(positions == std::vector<Vec3>{{2, 0, 100}, {4, 0, 100}, {2, 2, 100}, {0, 0, 100}, {2, 0, 100}, {0, 2, 100}});
}

TEST_CASE("3mf: lengths are the file's own numbers, and the unit is reported") {
  using enum api::LengthUnit;
  const std::string object = with_vertex("x=\"0.3\" y=\"1\" z=\"7\"");
  const auto read = [&](const std::string& unit) {
    return good_3mf(package(model(object, kItem, unit.empty() ? "" : "unit=\"" + unit + "\"")));
  };
  const std::pair<const char*, api::LengthUnit> units[] = {
      {"", millimeter}, {"micron", micron}, {"millimeter", millimeter}, {"centimeter", centimeter}, {"inch", inch},
      {"foot", foot},   {"meter", meter}};
  for (const auto& [name, unit] : units) {
    CAPTURE(name);
    const ReadMesh mesh = read(name);
    CHECK(mesh.mesh.positions[0] == Vec3(0.3, 1, 7));
    CHECK(mesh.notes.unit == unit);
  }
  CHECK(placed(object, item(1, "1 0 0 0 1 0 0 0 1 1 0 0"), "unit=\"inch\"")[0] == Vec3(1.3, 1, 7));
  CHECK(contains(refused_3mf(object, kItem, "unit=\"parsec\""), "line 2 of 'a': the unit 'parsec' is not known"));
}

TEST_CASE("3mf: objects outside the build are counted and not measured") {
  const ReadMesh read =
      good_3mf(package(model(triangle_object(1) + triangle_object(2) + assembly(3, component(2)), kItem)));
  CHECK(read.mesh.triangles.size() == 1);
  CHECK(read.notes.unused_objects == 2);
  CHECK(good_3mf(package(model(triangle_object(1), kItem))).notes.unused_objects == 0);
  CHECK(contains(refused_3mf(triangle_object(1) + triangle_object(2), ""), "its build places none of its 2 objects"));
  CHECK(code(package(model("", "")), "m.3mf") == ErrorCode::empty_mesh);
}

TEST_CASE("3mf: objects that are not printed are counted and not measured") {
  const auto typed = [](int id, const std::string& type) {
    std::string object = triangle_object(id);
    return object.replace(object.find("\"model\""), 7, "\"" + type + "\"");
  };
  const std::string both = kItem + "<item objectid=\"2\"/>";
  for (const char* type : {"support", "solidsupport", "other"}) {
    const ReadMesh read = good_3mf(package(model(triangle_object(1) + typed(2, type), both)));
    CHECK(read.mesh.triangles.size() == 1);
    CHECK(read.notes.helper_objects == 1);
    CHECK(read.notes.unused_objects == 0);
    const ReadMesh part = good_3mf(package(
        model(triangle_object(1) + typed(2, type) + assembly(3, component(1) + component(2)), item(3, kIdentity))));
    CHECK(part.mesh.triangles.size() == 1);
    CHECK(part.notes.helper_objects == 1);
    CHECK(contains(refused_3mf(typed(1, type)), "has no printed triangles"));
  }
  // The type of an object with components is overridden by theirs.
  std::string whole = assembly(3, component(1));
  whole.insert(whole.find("id="), "type=\"support\" ");
  CHECK(good_3mf(package(model(triangle_object(1) + whole, item(3, kIdentity)))).mesh.triangles.size() == 1);
  CHECK(good_3mf(package(model(triangle_object(1) + typed(2, "surface"), both))).mesh.triangles.size() == 2);
  CHECK(contains(refused_3mf(typed(1, "modle")), "line 4 of 'a': the type 'modle' of an object is not known"));
}

TEST_CASE("3mf: items marked as not printable") {
  const std::string resources = triangle_object(1) + triangle_object(2);
  const ReadMesh one = good_3mf(package(model(resources, kItem + "<item objectid=\"2\" printable=\"0\"/>")));
  CHECK(one.mesh.triangles.size() == 1);
  CHECK(one.notes.helper_objects == 1);
  CHECK(one.notes.unused_objects == 0);
  const ReadMesh again = good_3mf(package(model(triangle_object(1), kItem + "<item objectid=\"1\" printable=\"0\"/>")));
  CHECK(again.mesh.triangles.size() == 1);
  CHECK(again.notes.helper_objects == 1);
  CHECK(good_3mf(package(model(triangle_object(1), "<item objectid=\"1\" printable=\"1\"/>"))).mesh.triangles.size() ==
        1);
  CHECK(
      good_3mf(package(model(resources, kItem + "<item objectid=\"2\" printable=\"false\"/>"))).notes.helper_objects ==
      1);
  CHECK(contains(refused_3mf(resources, "<item objectid=\"2\" printable=\"0\"/>"), "marked as not printable"));
  CHECK(contains(refused_3mf(resources, "<item objectid=\"2\" printable=\"true\"/>"),
                 "'printable' is 'true'; write '0'"));
}

TEST_CASE("3mf: the helper meshes of Cura") {
  const auto with = [](const std::string& setting, const std::string& value) {
    std::string object = triangle_object(2);
    return object.insert(object.find("<mesh>"), "<metadatagroup><metadata name=\"" + setting +
                                                    "\" type=\"xs:boolean\">" + value + "</metadata></metadatagroup>");
  };
  const std::string both = kItem + "<item objectid=\"2\"/>";
  for (const char* name : {"support_mesh", "anti_overhang_mesh", "infill_mesh", "cutting_mesh"}) {
    for (const char* prefix : {"cura:", ""}) {
      const ReadMesh read =
          good_3mf(package(model(triangle_object(1) + with(prefix + std::string(name), "True"), both)));
      CHECK(read.mesh.triangles.size() == 1);
      CHECK(read.notes.helper_objects == 1);
    }
    CHECK(good_3mf(package(model(triangle_object(1) + with(name, "False"), both))).mesh.triangles.size() == 2);
  }
  CHECK(
      good_3mf(package(model(triangle_object(1) + with("cura:infill_pattern", "True"), both))).mesh.triangles.size() ==
      2);
  for (const std::string prefix : {"", "cura:"}) {  // as older versions wrote them
    std::string object = triangle_object(2);
    object.insert(object.find("<mesh>"), "<" + prefix + "settings><" + prefix + "setting key=\"support_mesh\">True</" +
                                             prefix + "setting></" + prefix + "settings>");
    const std::string attributes = "xmlns:cura=\"http://software.ultimaker.com/xml/cura/3mf/2015/10\"";
    const ReadMesh read = good_3mf(package(model(triangle_object(1) + object, both, attributes)));
    CHECK(read.mesh.triangles.size() == (prefix.empty() ? 1 : 2));
    CHECK(read.notes.helper_objects == (prefix.empty() ? 1 : 0));
    CHECK(read.notes.remarks.empty());
  }
}

TEST_CASE("3mf: volumes of PrusaSlicer, by ranges of triangles") {
  std::string object = triangle_object(1);
  const std::string triangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";
  object.insert(object.find(triangle), triangle + triangle + "<triangle v1=\"2\" v2=\"1\" v3=\"0\"/>");
  const auto with = [&](const std::string& volumes) {
    const std::string config = "<config><object id=\"1\">" + volumes + "</object></config>";
    return package(model(object, kItem + kItem), {{"Metadata/Slic3r_PE_model.config", config}});
  };
  const auto volume = [](const std::string& range, const std::string& key, const std::string& value) {
    return "<volume " + range + "><metadata type=\"volume\" key=\"" + key + "\" value=\"" + value + "\"/></volume>";
  };
  const std::string first = "firstid=\"0\" lastid=\"1\"", last = "firstid=\"3\" lastid=\"3\"";
  const std::string part = volume(first, "volume_type", "ModelPart");
  for (const char* type : {"ParameterModifier", "SupportEnforcer", "SupportBlocker", "SeamPosition"}) {
    const ReadMesh read = good_3mf(with(part + volume(last, "volume_type", type)));
    CHECK(read.mesh.triangles.size() == 6);
    CHECK(read.notes.helper_objects == 2);
  }
  CHECK(good_3mf(with(part + volume(last, "modifier", "1"))).mesh.triangles.size() == 6);
  const ReadMesh middle = good_3mf(with(volume(first, "modifier", "1") + volume(last, "modifier", "1")));
  CHECK(middle.mesh.triangles == std::vector<Triangle>{{2, 1, 0}, {5, 4, 3}});
  CHECK(middle.notes.helper_objects == 4);
  CHECK(good_3mf(with(volume(first, "modifier", "1") + volume(first, "modifier", "1"))).mesh.triangles.size() == 4);
  CHECK(good_3mf(with(part + volume(last, "modifier", "0"))).mesh.triangles.size() == 8);
  const std::string in = "Metadata/Slic3r_PE_model.config, line 1 of 'a': ";
  const auto refused_by = [&](const std::string& volumes) { return refusal(with(volumes), "m.3mf"); };
  CHECK(contains(refused_by(volume(last, "volume_type", "Hologram")), in + "the kind of volume 'Hologram'"));
  CHECK(contains(refused_by(volume("firstid=\"0\"", "modifier", "1")), in + "a volume without a valid range"));
  CHECK(contains(refused_by(volume("firstid=\"2\" lastid=\"1\"", "modifier", "1")), "without a valid range"));
  CHECK(contains(refused_by(volume("firstid=\"0\" lastid=\"4\"", "modifier", "1")), "a triangle that does not exist"));
  CHECK(contains(refused_by(volume(last, "volume_type", "NegativeVolume")), "object 1 of 'a': a negative volume"));
  CHECK(code(with(volume(last, "volume_type", "NegativeVolume")), "m.3mf") == ErrorCode::unsupported_format);
  CHECK(contains(refused_by(volume("firstid=\"0\" lastid=\"3\"", "modifier", "1")), "has no printed triangles"));
  CHECK(contains(refused_by("<volume>"), in + "not valid XML"));
}

TEST_CASE("3mf: volumes of Bambu Studio and OrcaSlicer, by components") {
  const auto with = [&](const std::string& parts, const std::string& build) {
    const std::string config = "<config><object id=\"3\">" + parts + "</object><plate/></config>";
    return package(model(triangle_object(1) + triangle_object(2) + assembly(3, component(1) + component(2)), build),
                   {{"Metadata/model_settings.config", config}});
  };
  const auto part = [](int id, const std::string& subtype) {
    return "<part id=\"" + std::to_string(id) + "\" subtype=\"" + subtype + "\"><mesh_stat/></part>";
  };
  const std::string build = item(3, kIdentity);
  for (const char* subtype : {"modifier_part", "support_enforcer", "support_blocker"}) {
    const ReadMesh read = good_3mf(with(part(1, "normal_part") + part(2, subtype), build));
    CHECK(read.mesh.triangles.size() == 1);
    CHECK(read.notes.helper_objects == 1);
    CHECK(good_3mf(with(part(2, subtype), build + item(2, kIdentity))).mesh.triangles.size() == 2);
  }
  CHECK(good_3mf(with(part(1, "normal_part") + "<part id=\"2\"/>", build)).mesh.triangles.size() == 2);
  CHECK(contains(refusal(with(part(2, "negative_part"), build), "m.3mf"), "object 2 of 'a': a negative volume"));
  CHECK(good_3mf(with(part(2, "negative_part"), kItem)).mesh.triangles.size() == 1);
  CHECK(contains(refusal(with(part(2, "hologram"), build), "m.3mf"), "the kind of volume 'hologram'"));
}

TEST_CASE("3mf: objects in other parts, by the production extension") {
  const std::string production =
      "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"";
  const std::string other = "p:path=\"/3D/Objects/One.model\"";
  const auto whole = [&](const std::string& resources, const std::string& build, const std::string& part) {
    return package(model(resources, build, production), {{"3D/Objects/one.model", part}});
  };
  const std::string root = assembly(1, component(1, other + " transform=\"1 0 0 0 1 0 0 0 1 0 0 4\""));
  const ReadMesh read =
      good_3mf(whole(root, kItem, model(triangle_object(1) + triangle_object(7), item(7, "ignored"))));
  CHECK(read.mesh.positions[1] == Vec3(1, 0, 4));
  CHECK(read.mesh.triangles.size() == 1);
  CHECK(read.notes.unused_objects == 1);
  CHECK(good_3mf(whole("", "<item objectid=\"7\" " + other + "/>", model(triangle_object(7), ""))).mesh.positions ==
        kTriangle);
  CHECK(contains(refusal(whole(root, kItem, model(triangle_object(1), "", "unit=\"inch\"")), "m.3mf"),
                 "3D/Objects/One.model, line 2 of 'a': the unit is 'in', that of the root model 'mm'"));
  CHECK(contains(refusal(whole(root, kItem, model(triangle_object(2), "")), "m.3mf"),
                 "3D/Objects/One.model, object 1 of 'a': does not exist, but 3D/3dmodel.model places it"));
  CHECK(contains(refusal(whole(root, kItem, model(assembly(1, component(2, other)), "", production)), "m.3mf"),
                 "a path to another part, which only the root model may have"));
  CHECK(contains(refused_3mf(root, kItem, production), "3D/Objects/One.model of 'a': missing from the zip archive"));
}

TEST_CASE("3mf: extensions without effect on the surface pass, others are refused by name") {
  const std::string standards = "http://schemas.microsoft.com/3dmanufacturing/";
  const auto with = [&](const std::string& name_space, const std::string& more) {
    return "xmlns:e=\"" + name_space + "\" " + more;
  };
  std::string lattice = triangle_object(1);
  lattice.insert(lattice.find("</mesh>"), "<e:beamlattice/>");
  const std::string required = "requiredextensions=\"e\"";
  CHECK(placed(triangle_object(1), kItem, with(standards + "material/2015/02", required)) == kTriangle);
  CHECK(placed(lattice, kItem, with(standards + "trianglesets/2021/07", required)) == kTriangle);
  CHECK(placed(lattice, kItem, with("http://slicer.example/notes", "")) == kTriangle);
  CHECK(placed(triangle_object(1), kItem, with(standards + "slice/2015/07", "")) == kTriangle);
  CHECK(contains(
      refused_3mf(lattice, kItem, with(standards + "beamlattice/2017/02", "")),
      "geometry of the extension '" + standards + "beamlattice/2017/02' (a beam lattice), which is not supported"));
  CHECK(contains(refused_3mf("<object id=\"1\"><e:booleanshape/></object>", kItem,
                             with("http://schemas.3mf.io/3dmanufacturing/booleanoperations/2023/07", "")),
                 "geometry of the extension"));
  const std::pair<std::string, std::string> topics[] = {{"slice/2015/07", " (slices)"},
                                                        {"securecontent/2019/04", " (encrypted content)"},
                                                        {"beamlattice/2017/02", " (a beam lattice)"},
                                                        {"something/2030/01", ""}};
  for (const auto& [name, topic] : topics) {
    CHECK(contains(
        refused_3mf(triangle_object(1), kItem, with(standards + name, required)),
        "line 2 of 'a': it requires the extension '" + standards + name + "'" + topic + ", which is not supported"));
  }
  CHECK(contains(refused_3mf(triangle_object(1), kItem, "requiredextensions=\"x\""), "extension 'x' is not declared"));
  CHECK(code(package(model(triangle_object(1), kItem, with("http://other.example", required))), "m.3mf") ==
        ErrorCode::unsupported_format);
}

TEST_CASE("3mf: malformed models are refused with part and line") {
  const std::string here = "3D/3dmodel.model, line 4 of 'a': ";
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"1,5\" z=\"0\"")), here + "the coordinate '1,5' is not a number"));
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"\" z=\"0\"")), "the coordinate '' is not a number"));
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"1 2\" z=\"0\"")), "is not a number"));
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"nan\" z=\"0\"")), "the coordinate 'nan' is not finite"));
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"1e999\" z=\"0\"")), "the coordinate '1e999' is not finite"));
  CHECK(contains(refused_3mf(with_vertex("x=\"0\" y=\"1\"")), here + "a vertex needs the attributes x, y and z"));
  CHECK(
      contains(refused_3mf(with_triangle("v1=\"0\" v2=\"1\" v3=\"3\"")), here + "index '3', but there are 3 vertices"));
  CHECK(contains(refused_3mf(with_triangle("v1=\"0\" v2=\"1\" v3=\"-1\"")), "'-1' is not an index"));
  CHECK(contains(refused_3mf(with_triangle("v1=\"0\" v2=\"1\" v3=\"1.0\"")), "'1.0' is not an index"));
  CHECK(contains(refused_3mf(with_triangle("v1=\"0\" v2=\"1\"")), "a triangle needs the attributes v1, v2 and v3"));
  CHECK(contains(refused_3mf(triangle_object(1) + triangle_object(1)), "a second object 1"));
  CHECK(contains(refused_3mf("<object><mesh/></object>"), "an object without a valid id"));
  CHECK(contains(refused_3mf("<object id=\"1\"><mesh/><mesh/></object>"), "a second mesh"));
  CHECK(contains(refused_3mf("<object id=\"1\"><mesh/><components/></object>"), "components beside a mesh"));
  CHECK(contains(refused_3mf(triangle_object(1), "<item/>"), "line 5 of 'a': no valid objectid"));
  CHECK(contains(refused_3mf(triangle_object(1), item(1, "1 0 0")), "the transform '1 0 0' must have twelve"));
  CHECK(contains(refused_3mf(triangle_object(1), item(1, "1 0 0 0 1 0 0 0 1 0 0 0x")), "must have twelve"));
  CHECK(contains(refused_3mf(triangle_object(1), item(1, "1 0 0 0 1 0 0 0 1 0 0 nan")), "must have twelve"));
  CHECK(contains(refused_3mf(triangle_object(1), item(1, "1 0 0 0 1 0 0 0 1 0 0 0 0")), "more than twelve numbers"));
  CHECK(
      contains(refused_3mf(triangle_object(1), item(2, "1 0 0 0 1 0 0 0 1 0 0 0")), "object 2 of 'a': does not exist"));
  CHECK(contains(refusal(package("<model/>"), "m.3mf"), "the root element 'model' is not the model of 3MF's core"));
  CHECK(contains(refusal(package("<html>"), "m.3mf"), "3D/3dmodel.model, line 1 of 'a': the root element 'html'"));
}

TEST_CASE("3mf: cycles, ladders and long chains of components end") {
  CHECK(contains(refused_3mf(assembly(1, component(1))), "3D/3dmodel.model, object 1 of 'a': a component of itself"));
  CHECK(contains(refused_3mf(assembly(1, component(2)) + assembly(2, component(1))),
                 "object 1 of 'a': a component of itself"));
  std::string ladder = triangle_object(41);
  std::string chain = triangle_object(100);
  for (int i = 1; i <= 40; ++i) ladder += assembly(i, component(i + 1) + component(i + 1));
  for (int i = 1; i < 100; ++i) chain += assembly(i, component(i + 1));
  CHECK(contains(refused_3mf(ladder), "places more than 1000000 objects and components"));
  CHECK(contains(refused_3mf(chain), "components nested deeper than 64"));
  std::string many;
  for (int i = 0; i < 1'000'001; ++i) many += "<component objectid=\"1\"/>";
  CHECK(contains(refused_3mf(assembly(2, many), ""), "more than 1000000 objects, components and items"));
}

TEST_CASE("3mf: the limits of vertices and triangles hold over all instances") {
  std::string build;
  for (int i = 0; i < 10; ++i) build += kItem;
  const std::string file = package(model(triangle_object(1), build));
  ReadLimits limits;
  limits.max_triangles = 10;
  limits.max_vertices = 30;
  CHECK(read(file, "m.3mf", limits).ok());
  const auto refused_by = [&](std::size_t triangles, std::size_t vertices) {
    limits.max_triangles = triangles;
    limits.max_vertices = vertices;
    auto result = read(file, "m.3mf", limits);
    REQUIRE(!result.ok());
    CHECK(result.error().code == ErrorCode::too_large);
    return result.error().message;
  };
  CHECK(contains(refused_by(9, 30), "more triangles than the limit of 9"));
  CHECK(contains(refused_by(10, 29), "more vertices than the limit of 29"));
  CHECK(contains(refused_by(0, 30), "line 4 of 'a': more triangles than the limit of 0"));
  CHECK(contains(refused_by(10, 2), "line 4 of 'a': more vertices than the limit of 2"));
}

TEST_CASE("3mf: archives that are not packages, or of another kind") {
  const std::string part = model(triangle_object(1), kItem);
  const auto message = [&](const std::vector<ZipEntry>& entries) { return refusal(zip(entries), "m.3mf"); };
  CHECK(good_3mf(zip({{"_RELS/.rels", relationships("3D/other.MODEL"), 0}, {"3d/Other.model", part}})).mesh.positions ==
        kTriangle);
  CHECK(contains(message({{"m.stl", "solid"}}), "'a' is a zip archive, not a mesh"));
  CHECK(contains(message({}), "'a' is a zip archive"));
  CHECK(contains(message({{"_rels/.rels", "<Relationships/>"}}), "a package without a 3D model"));
  CHECK(contains(message({{"_rels/.rels", relationships()}}), "3D/3dmodel.model of 'a': missing"));
  CHECK(contains(message({{"_rels/.rels", relationships("http://x\" TargetMode=\"External")}}),
                 "_rels/.rels, line 2 of 'a': the model 'http://x' is outside of the file"));
  std::string twice = relationships();
  twice.insert(twice.find("<Relationship Type=\"http://schemas.microsoft"),
               "<Relationship Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\" Target=\"/b\"/>");
  CHECK(contains(message({{"_rels/.rels", twice}, {"b", part}}), "a second root model, '/3D/3dmodel.model'"));
  CHECK(contains(message({{"_rels/.rels", relationships()}, {"3D/3dmodel.model", part, 8, 1}}), "encrypted"));
}

TEST_CASE("3mf: also compressed by gzip, with limits by the size sent") {
  const std::string file = package(model(triangle_object(1), kItem));
  const auto read = good_3mf(gzipped(file));
  CHECK(read.notes.gzip);
  CHECK(read.mesh.positions == kTriangle);
  // 60 MB that are not compressed allow for more than these 80 MB, but not when they are compressed themselves.
  const std::string part = model(std::string(80'000'000, ' '), "");
  const std::string padded = package(part, {{"padding", std::string(60'000'000, ' '), 0}});
  CHECK(code(padded, "m.3mf") == ErrorCode::empty_mesh);
  CHECK(contains(refusal(gzipped(padded), "m.3mf"), "expands to more than 67108864 bytes"));
  CHECK(contains(refusal(package(part), "m.3mf"), "expands to more than 67108864 bytes"));
}

}  // namespace meshgauge::api::test
