#include "api/formats/format.h"

#include <doctest/doctest.h>

#include "api/formats/detect.h"
#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

const std::string kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::optional<Format> detected(std::string_view content, std::string_view filename, std::string_view media_type = "") {
  return detect_format(bytes_of(content), ReadHints{"a", filename, media_type});
}

std::string with_nuls(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '0' ? '\0' : c;
  return out;
}

}  // namespace

TEST_CASE("format: content goes before the name, the name before the media type") {
  CHECK(detected(kObj, "m.stl", "model/stl") == Format::obj);
  CHECK(detected("# comment\n\n g part\n", "") == Format::obj);
  CHECK(detected("ply\nformat", "m.obj") == Format::ply);
  CHECK(detected("OFF\n1 1 1", "") == Format::off);
  CHECK(detected("glTF....", "m.obj") == Format::glb);
  CHECK(detected(" {\"asset\"", "") == Format::gltf);
  CHECK(detected("\xEF\xBB\xBF{}", "") == Format::gltf);
  CHECK(detected("solid x\nfacet", "") == Format::stl);
  CHECK(detected("??", "a.b/M.STL.gz", "model/obj") == Format::stl);
  CHECK(detected("??", "scan.PlY") == Format::ply);
  CHECK(detected("??", "noname", "model/gltf-binary; v=2") == Format::glb);
  CHECK(detected("??", "obj", "Model/OBJ") == Format::obj);
  CHECK(detected("??", "m.obj.txt", "text/plain") == std::nullopt);
  CHECK(detected("PK\x03\x04", "m.obj", "") == Format::three_mf);
  CHECK(detected("??", "part", "model/3mf") == Format::three_mf);
}

TEST_CASE("format: every format has its own name") {
  for (const Format format :
       {Format::obj, Format::stl, Format::ply, Format::off, Format::gltf, Format::glb, Format::three_mf, Format::xyz}) {
    CHECK(detected("??", "m." + std::string(to_string(format))) == format);
  }
}

TEST_CASE("format: files that are not meshes are refused with their kind") {
  CHECK(contains(refusal("", "m.obj"), "'a' is an empty file"));
  CHECK(contains(refusal("<!DOCTYPE html><html>", "m.stl"), "web page"));
  CHECK(contains(refusal(" \n<HTML lang=en>", "m.stl"), "web page"));
  CHECK(contains(refusal("\x89PNG\r\n\x1A\n", "m.obj"), "PNG"));
  CHECK(contains(refusal("PK\x03\x04....", "m.stl"), "zip archive"));
  CHECK(contains(refusal("<?xml version=\"1.0\"?><COLLADA>", "m.dae"), "XML file"));
  CHECK(contains(refusal("DRACO\x02\x02", "m.drc"), "Draco"));
  CHECK(contains(refusal("\xFF\xFE" + with_nuls("v0 0"), "m.obj"), "UTF-16"));
  CHECK(contains(refusal(with_nuls("v0 010203040"), "m.obj"), "UTF-16"));
  CHECK(contains(refusal(with_nuls("0v0 01020304"), "m.obj"), "UTF-16"));
  CHECK(contains(refusal(with_nuls("##0\x01\x02 #0\x01##"), "m.obj"), "binary data"));
  CHECK(contains(refusal("hello", "m.txt"), "has an unknown format"));
  CHECK(contains(refusal("hello", ""), "has an unknown format"));
  CHECK(code("hello world", "m.obj") == ErrorCode::unsupported_format);
  CHECK(code("hello", "") == ErrorCode::unsupported_format);
}

TEST_CASE("format: files of unsupported formats are refused with their format") {
  const auto is = [](const std::string& content, const std::string& name, const std::string& what) {
    CHECK(contains(refusal(content, name), "'a' is " + what));
    CHECK(code(content, name) == ErrorCode::unsupported_format);
  };
  for (const char* name : {"m.fbx", "m.obj", ""}) {
    is(std::string("Kaydara FBX Binary  \0\x1A\0", 23), name, "an FBX file");
    is("; FBX 7.7.0 project file\n", name, "an FBX file");
    is("  0\nSECTION\n  2\nHEADER\n", name, "a DXF file");
    is("999\nmade by a test\n0\r\nSECTION\r\n", name, "a DXF file");
    is("999\r\nmade by a test\r\n  0\r\nSECTION\r\n", name, "a DXF file");
    is("999\rmade by a test\r0\rSECTION\r", name, "a DXF file");
    is("#Inventor V2.1 ascii\n", name, "an Inventor file");
    is("AutoCAD Binary DXF\r\n", name, "a DXF file");
    is(std::string("MM\x20\0\0\0\x02\0\x0A\0\0\0\x03\0\0\0", 16), name, "a 3DS file");
    is(std::string("MM\x20\0\0\0==\x0A\0\0\0", 12), name, "a 3DS file");
    is("ISO-10303-21;\nHEADER;", name, "a STEP file");
    is(std::string(72, ' ') + "S      1\n", name, "an IGES file");
    is("#VRML V2.0 utf8\n", name, "a VRML file");
    is("#usda 1.0\n", name, "a USD file");
    is("# vtk DataFile Version 3.0\n", name, "a VTK file");
    is("$MeshFormat\n2.2 0 8\n", name, "a Gmsh file");
  }
  CHECK(detected("MM\nv 0 0 0\n", "m.obj") == Format::obj);
  CHECK(!contains(refusal("0\nSECTIONS\n", ""), "DXF"));
  for (const char* word : {"#VRML", "#VRML export of a part", "#Inventor 2024", "#usda", "#usda of the shop"}) {
    CHECK(read(word + ("\n" + kObj), "m.obj").ok());
  }
  for (const char* header : {"#VRML V2.0 utf8", "; FBX 7.7.0 project file", "#usda 1.0"}) {
    std::string stl = header + std::string(80 - std::strlen(header), ' ') + raw(std::uint32_t{1});
    for (const float c : {0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F}) stl += raw(c);
    CHECK(read(stl + std::string(2, '\0'), "m.stl").ok());
  }
  CHECK(!contains(refusal("999\n", ""), "DXF"));
}

TEST_CASE("format: a Git LFS pointer is recognised under every name") {
  const std::string pointer =
      "version https://git-lfs.github.com/spec/v1\noid sha256:" + std::string(64, 'a') + "\nsize 12345\n";
  for (const char* name : {"m.obj", "m.stl", "m.ply", "m.off", "m.gltf", "m.glb", "m.3mf", "m.stl.gz", ""}) {
    CHECK(refusal(pointer, name) == "'a' is a Git LFS pointer, not a mesh: 'git lfs pull' puts the file in its place");
    CHECK(code(pointer, name) == ErrorCode::unsupported_format);
  }
}

TEST_CASE("format: a name or a media type that contradicts the content is noted") {
  const auto notes = [](std::string_view filename, std::string_view media_type) {
    auto result = read_mesh(bytes_of(kObj), ReadHints{"a", filename, media_type}, {});
    REQUIRE(result.ok());
    CHECK(result->format == Format::obj);
    return result->notes;
  };
  CHECK(notes("m.stl", "").filename_says == Format::stl);
  CHECK(notes("m.PLY.gz", "model/obj").filename_says == Format::ply);
  CHECK(notes("m.obj", "model/gltf-binary; q=1").media_type_says == Format::glb);
  for (const char* name : {"m.obj", "M.OBJ.gz", "m", "m.txt", ""}) {
    for (const char* type : {"", "application/octet-stream", "Model/OBJ"}) {
      CHECK(notes(name, type).filename_says == std::nullopt);
      CHECK(notes(name, type).media_type_says == std::nullopt);
    }
  }
}

TEST_CASE("format: messages are printable ASCII for any content") {
  const std::string message = refusal(kObj + "v 1 2 \xFF\xC3\x28\x7F\x01\"'\n", "m.obj");
  CHECK(contains(message, "is not a number"));
  for (const char c : message) CHECK((c >= ' ' && c <= '~'));
}

TEST_CASE("format: the part is named in every refusal") {
  const ReadHints hints{"b", "m.obj", ""};
  auto result = read_mesh(bytes_of("v 1 2\n"), hints, {});
  REQUIRE(!result.ok());
  CHECK(result.error().part == "b");
  CHECK(result.error().where == "line 1");
  CHECK(contains(result.error().message, "line 1 of 'b'"));
}

}  // namespace meshgauge::api::test
