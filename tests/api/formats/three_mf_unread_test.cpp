// What a 3MF may hold of a surface and is not read: noted or refused, never passed in silence.
#include "api/formats/file/readers.h"

#include "tests/api/formats/three_mf_files.h"

namespace meshgauge::api::test {
namespace {

using Remarks = std::vector<std::string>;

const std::string kVendor = "xmlns:x=\"http://vendor.example/x\" ";
const std::string kStandards = "http://schemas.microsoft.com/3dmanufacturing/";
const std::string kNotRead = "not read and not measured, though part of the surface: ";
const std::string kHere = "3D/3dmodel.model, line 4 of 'a': ";

Remarks remarks_of(const std::string& resources, const std::string& attributes = kVendor,
                   const std::string& build = kItem) {
  const ReadMesh read = good_3mf(package(model(resources, build, attributes)));
  CHECK(read.mesh.triangles.size() == 1);
  return read.notes.remarks;
}

std::string refused(const std::string& resources, const std::string& attributes = kVendor,
                    const std::string& build = kItem) {
  return refusal(package(model(resources, build, attributes)), "m.3mf");
}

// The object of triangle_object() with `added` in front of the first `place`.
std::string with(const std::string& place, const std::string& added) {
  std::string object = triangle_object(1);
  REQUIRE(contains(object, place));
  return object.insert(object.find(place), added);
}

const std::string kXmlTriangle = "<triangle v1=\"0\" v2=\"1\" v3=\"2\"/>";

std::string with_inside_triangle(const std::string& inside) {
  std::string object = triangle_object(1);
  return object.replace(object.find("/></triangles>"), 2, ">" + inside + "</triangle>");
}

}  // namespace

TEST_CASE("3mf unread: an element of the core that 3MF does not have there is refused by name and line") {
  for (const char* name : {"TRIANGLE", "Triangle", "tri", "quad", "vertex"}) {
    const std::string element = "<" + std::string(name) + " v1=\"0\" v2=\"1\" v3=\"2\"/>";
    CHECK(refused(with("</triangles>", element)) ==
          kHere + "the element '" + name + "' inside 'triangles' is unknown; 3MF has 'triangle' there");
    CHECK(code(package(model(with("</triangles>", element), kItem)), "m.3mf") == ErrorCode::unreadable_mesh);
  }
  const std::pair<const char*, const char*> others[] = {
      {"</vertices>", "inside 'vertices' is unknown; 3MF has 'vertex' there"},
      {"</mesh>", "inside 'mesh' is unknown; 3MF has 'vertices', 'triangles' there"},
      {"</object>", "inside 'object' is unknown; 3MF has 'mesh', 'components' there"}};
  for (const auto& [place, what] : others) CHECK(contains(refused(with(place, "<facet/>")), what));
  CHECK(contains(refused("<object id=\"2\"><components><part/></components></object>"),
                 "'part' inside 'components' is unknown; 3MF has 'component' there"));
  CHECK(contains(refused(triangle_object(1), "", kItem + "<Item objectid=\"1\"/>"),
                 "line 5 of 'a': the element 'Item' inside 'build' is unknown; 3MF has 'item' there"));
  CHECK(contains(refused(with_inside_triangle(kXmlTriangle)), "'triangle' inside 'triangle'"));
  CHECK(contains(refused(triangle_object(1) + "<Object id=\"2\"/>"),
                 "the element 'Object' inside 'resources' is unknown; 3MF has 'object' there"));
  std::string twice = package(model(triangle_object(1), kItem + "</build><Build>" + kItem + "</Build><build>"));
  CHECK(contains(refusal(twice, "m.3mf"), "the element 'Build' inside 'model' is unknown"));
}

TEST_CASE("3mf unread: attributes of 3MF itself with a prefix, and a fourth corner, are refused") {
  const std::string core = "xmlns:q=\"" + kStandards + "core/2015/02\"";
  const std::string moved = "<item objectid=\"1\" q:transform=\"1 0 0 0 1 0 0 0 1 5 0 0\"/>";
  for (const std::string& attributes : {core, std::string()}) {
    CHECK(contains(refused(triangle_object(1), attributes, moved),
                   "the attribute 'q:transform' has a prefix; 3MF writes 'transform' without one"));
  }
  CHECK(contains(refused(triangle_object(1), core + " q:unit=\"inch\""), "'q:unit' has a prefix"));
  for (const char* corner : {"v4", "V3"}) {
    std::string object = triangle_object(1);
    object.insert(object.find("v1="), std::string(corner) + "=\"0\" ");
    CHECK(contains(refused(object), "the attribute '" + std::string(corner) + "' of a triangle is unknown"));
  }
}

TEST_CASE("3mf unread: elements of other namespaces in objects and in the build are counted and named") {
  const std::string foreign = "<x:curved v1=\"0\"><x:more/></x:curved>";
  const auto note = [](const std::string& place, int count = 1) {
    return Remarks{kNotRead + "elements 'x:curved' inside '" + place + "': " + std::to_string(count)};
  };
  CHECK(remarks_of(with("</triangles>", foreign + foreign)) == note("triangles", 2));
  CHECK(remarks_of(with("</vertices>", foreign)) == note("vertices"));
  CHECK(remarks_of(with("</mesh>", foreign)) == note("mesh"));
  CHECK(remarks_of(with("</object>", foreign)) == note("object"));
  CHECK(remarks_of(with_inside_triangle(foreign)) == note("triangle"));
  CHECK(remarks_of(triangle_object(1), kVendor, kItem + foreign) == note("build"));
  const std::string assembly =
      "<object id=\"2\"><components><component objectid=\"1\"/>" + foreign + "</components></object>";
  CHECK(remarks_of(triangle_object(1) + assembly, kVendor, "<item objectid=\"2\"/>") == note("components"));
  // Without a namespace, as in a document whose root declares the core under a prefix only.
  CHECK(remarks_of(with("</triangles>", "<triangle xmlns=\"\" v1=\"0\"/>")) ==
        Remarks{kNotRead + "elements 'triangle' inside 'triangles': 1"});
}

TEST_CASE("3mf unread: a file of nothing else is refused by the same names") {
  std::string object = triangle_object(1);
  object.replace(object.find(kXmlTriangle), kXmlTriangle.size(), "<x:curved/><x:curved/>");
  CHECK(refused(object) ==
        "'a' has no triangles, only what is not read (elements 'x:curved' inside 'triangles': 2): export it as "
        "triangles");
  CHECK(code(package(model(object, kItem, kVendor)), "m.3mf") == ErrorCode::unsupported_format);
  // Triangles outside of the build do not help.
  CHECK(contains(refused(object + triangle_object(2)), "has no triangles, only what is not read (elements 'x:curved'"));
}

TEST_CASE("3mf unread: once for an object of the build, not for others") {
  const std::string foreign = with("</triangles>", "<x:curved/>");
  const ReadMesh twice = good_3mf(package(model(foreign, kItem + kItem, kVendor)));
  CHECK(twice.notes.remarks == Remarks{kNotRead + "elements 'x:curved' inside 'triangles': 1"});
  CHECK(remarks_of(foreign + triangle_object(2), kVendor, "<item objectid=\"2\"/>").empty());
}

TEST_CASE("3mf unread: what has no effect on the surface is ignored") {
  CHECK(remarks_of(triangle_object(1) + "<x:resource id=\"9\"><x:more/></x:resource>").empty());
  CHECK(remarks_of(triangle_object(1) + "<basematerials id=\"9\"><base name=\"a\"/></basematerials>").empty());
  CHECK(remarks_of(with("<mesh>", "<metadatagroup><metadata name=\"a\">b</metadata></metadatagroup>")).empty());
  CHECK(remarks_of(triangle_object(1), kVendor,
                   "<item objectid=\"1\"><metadatagroup><metadata name=\"a\"/></metadatagroup></item>")
            .empty());
  CHECK(remarks_of(with("v1=", "x:supports=\"8\" pid=\"1\" p1=\"2\" paint_color=\"4\" ")).empty());
  CHECK(remarks_of(with("</mesh>", "<x:trianglesets><x:triangleset><x:ref/></x:triangleset></x:trianglesets>"),
                   "xmlns:x=\"" + kStandards + "trianglesets/2021/07\"")
            .empty());
  CHECK(remarks_of(triangle_object(1) + "<x:multiproperties id=\"8\"><multi/><x:multi/></x:multiproperties>",
                   "xmlns:x=\"" + kStandards + "material/2015/02\"")
            .empty());
}

TEST_CASE("3mf unread: core geometry inside of an element that is not read is refused") {
  const std::string compatibility = "xmlns:mc=\"http://schemas.openxmlformats.org/markup-compatibility/2006\"";
  const auto wrapped = [](const std::string& inside) {
    return "<mc:AlternateContent><mc:Choice Requires=\"x\">" + inside + "</mc:Choice></mc:AlternateContent>";
  };
  const auto wrong = [](const std::string& name) {
    return "the element '" + name + "' inside 'mc:AlternateContent', which is not read; write it outside of that";
  };
  CHECK(refused(triangle_object(1) + wrapped(triangle_object(2)), compatibility) == kHere + wrong("object"));
  CHECK(contains(refused(with("</triangles>", wrapped(kXmlTriangle)), compatibility), wrong("triangle")));
  CHECK(contains(refused(triangle_object(1), compatibility, kItem + wrapped(kItem)), wrong("item")));
  CHECK(contains(refused(triangle_object(1), compatibility, kItem + "</build>" + wrapped("<build/>") + "<build>"),
                 wrong("build")));
  CHECK(code(package(model(wrapped(triangle_object(1)), kItem, compatibility)), "m.3mf") ==
        ErrorCode::unsupported_format);
  CHECK(remarks_of(triangle_object(1) + wrapped("<basematerials/>"), compatibility).empty());
}

TEST_CASE("3mf unread: geometry of each extension of the standard is refused by name") {
  const std::string newer = "http://schemas.3mf.io/3dmanufacturing/";
  struct Extension {
    std::string name_space;
    std::string place;
    std::string element;
    std::string topic;
  };
  const Extension extensions[] = {
      {kStandards + "beamlattice/2017/02", "</mesh>", "beamlattice", " (a beam lattice)"},
      {newer + "booleanoperations/2023/07", "</object>", "booleanshape", " (boolean operations)"},
      {newer + "volumetric/2022/01", "</object>", "levelset", " (volumetric content)"},
      {newer + "volumetric/2022/01", "</mesh>", "volumedata", " (volumetric content)"},
      {newer + "displacement/2023/10", "</object>", "displacementmesh", " (displaced surfaces)"},
      {kStandards + "production/alternatives/2021/04", "</object>", "alternatives", " (alternative objects)"},
      {kStandards + "something/2030/01", "</triangles>", "curve", ""}};
  for (const auto& [name_space, place, element, topic] : extensions) {
    CHECK(refused(with(place, "<e:" + element + "/>"), "xmlns:e=\"" + name_space + "\"") ==
          kHere + "geometry of the extension '" + name_space + "'" + topic + ", which is not supported");
  }
}

TEST_CASE("3mf unread: slices beside a mesh are noted, slices in place of it are refused") {
  const std::string slices = "xmlns:s=\"" + kStandards + "slice/2015/07\"";
  const std::string stack = "<s:slicestack id=\"5\"><s:slice/></s:slicestack>";
  CHECK(remarks_of(stack + with("type=", "s:slicestackid=\"5\" "), slices) ==
        Remarks{kNotRead + "attributes 's:slicestackid' of 'object': 1"});
  CHECK(remarks_of(with("type=", "s:meshresolution=\"fullres\" "), slices).empty());
  CHECK(refused(with("type=", "s:meshresolution=\"lowres\" s:slicestackid=\"5\" "), slices) ==
        kHere +
            "the attribute 's:meshresolution' is 'lowres': the surface is in an extension that is not supported; "
            "save the object at full resolution");
  CHECK(contains(refused(with("type=", "a:modelresolution=\"obfuscated\" "),
                         "xmlns:a=\"" + kStandards + "production/alternatives/2021/04\""),
                 "the attribute 'a:modelresolution' is 'obfuscated'"));
  CHECK(remarks_of(stack + triangle_object(1), slices).empty());
  CHECK(contains(refused(stack + "<object id=\"1\" s:slicestackid=\"5\"/>", slices),
                 "'a' has no triangles, only what is not read (attributes 's:slicestackid' of 'object': 1)"));
}

TEST_CASE("3mf unread: an encrypted part is refused as such") {
  const std::string production = "xmlns:p=\"" + kStandards + "production/2015/06\"";
  const std::string file = package(model("", "<item objectid=\"1\" p:path=\"/3D/secret.model\"/>", production),
                                   {{"3D/secret.model", "%3McF\x01\x02\x03"}, {"Secure/keystore.xml", "<keystore/>"}});
  CHECK(refusal(file, "m.3mf") ==
        "3D/secret.model of 'a': encrypted by the secure content extension, which is not supported; save it without "
        "encryption");
  CHECK(code(file, "m.3mf") == ErrorCode::unsupported_format);
}

TEST_CASE("3mf unread: a prefix that is not declared is named, with what it marks ignored") {
  const auto note = [](const std::string& prefixes) {
    return "prefixes that are not declared, their elements and attributes ignored: " + prefixes;
  };
  CHECK(remarks_of(triangle_object(1) + "<ms:pbmetallic name=\"a\"/>") == Remarks{note("'ms'")});
  CHECK(remarks_of(with("type=", "v:tag=\"1\" "), "u:tag=\"1\"") == Remarks{note("'u', 'v'")});
  CHECK(remarks_of(triangle_object(1) + "<e:a/><d:a/><c:a/><b:a/><a:a/>") ==
        Remarks{note("'b', 'c', 'd', 'e' and perhaps more")});
  // Among geometry the elements are counted as well.
  CHECK(remarks_of(with("</triangles>", "<ms:curved/>")) ==
        Remarks{kNotRead + "elements 'ms:curved' inside 'triangles': 1", note("'ms'")});
  // The place of an object is never ignored.
  CHECK(refused(triangle_object(1), "", "<item objectid=\"1\" p:path=\"/3D/b.model\"/>") ==
        "3D/3dmodel.model, line 5 of 'a': the attribute 'p:path' names another part, but its prefix is not declared");
  CHECK(contains(refused(triangle_object(1), "requiredextensions=\"ms\""), "extension 'ms' is not declared"));
  std::string relations = relationships();
  relations.insert(relations.find("<Relationship Type"), "<x:y/>");
  CHECK(contains(refusal(zip({{"_rels/.rels", relations}}), "m.3mf"),
                 "_rels/.rels, line 2 of 'a': not valid XML: the prefix of 'x:y' is not declared"));
}

TEST_CASE("3mf unread: attributes that place or scale an object are not passed over for their spelling") {
  const auto wrong = [](const std::string& seen, const std::string& meant) {
    return "the attribute '" + seen + "' is unknown; 3MF spells it '" + meant + "'";
  };
  CHECK(contains(refused(triangle_object(1), "Unit=\"inch\""), wrong("Unit", "unit")));
  CHECK(contains(refused(triangle_object(1), "requiredExtensions=\"x\""),
                 wrong("requiredExtensions", "requiredextensions")));
  CHECK(contains(refused(triangle_object(1), "", "<item objectid=\"1\" Transform=\"2 0 0 0 2 0 0 0 2 0 0 0\"/>"),
                 wrong("Transform", "transform")));
  CHECK(contains(refused(with("id=", "TYPE=\"support\" ")), wrong("TYPE", "type")));
  CHECK(contains(refused(triangle_object(1), "", "<item objectid=\"1\" path=\"/3D/b.model\"/>"),
                 "the attribute 'path' without the prefix of the production extension"));
}

TEST_CASE("3mf unread: relationships relative to the root of the package") {
  const std::string part = model(triangle_object(1), kItem);
  for (const char* target : {"/3D/3dmodel.model", "3D/3dmodel.model", "./3D/3dmodel.model", "/./3D/3dmodel.model",
                             "3D/./3dmodel.model", "//3D//3dmodel.model"}) {
    CAPTURE(target);
    const ReadMesh read = good_3mf(zip({{"_rels/.rels", relationships(target)}, {"3D/3dmodel.model", part}}));
    CHECK(read.notes.remarks.empty());
  }
  CHECK(contains(
      refusal(zip({{"_rels/.rels", relationships("../3D/3dmodel.model")}, {"3D/3dmodel.model", part}}), "m.3mf"),
      "../3D/3dmodel.model of 'a': missing from the zip archive"));
}

TEST_CASE("3mf unread: backslashes in the names of the archive are noted, two entries of one name refused") {
  const std::string part = model(triangle_object(1), kItem);
  const std::vector<ZipEntry> entries{{"_rels\\.rels", relationships("./3D/3dmodel.model")},
                                      {"3D\\3dmodel.model", part}};
  CHECK(good_3mf(zip(entries)).notes.remarks ==
        Remarks{"names in the archive with '\\' between folders, read as '/': 2"});
  std::vector<ZipEntry> both = entries;
  both.push_back({"3D/3dmodel.model", model("", "")});
  CHECK(refusal(zip(both), "m.3mf") ==
        "3d\\3dmodel.model of 'a': occurs twice in the zip archive, with '/' and with '\\' between folders");
}

TEST_CASE("3mf unread: models that the root model does not use are counted") {
  const std::string unused = model(triangle_object(1), kItem);
  const ReadMesh read = good_3mf(package(
      model(triangle_object(1), kItem),
      {{"3D/Other.model", unused}, {"__MACOSX/3D/._3dmodel.model", "attributes"}, {"2D/slices.model", "<model/>"}}));
  CHECK(read.mesh.triangles.size() == 1);
  CHECK(read.notes.remarks == Remarks{"models in the archive that the root model does not use, not read: 2"});
}

}  // namespace meshgauge::api::test
