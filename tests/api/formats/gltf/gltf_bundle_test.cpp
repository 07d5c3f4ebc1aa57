// A glTF of several files: the archive that it becomes, and the reader of such archives.
#include "api/formats/gltf/gltf_bundle.h"

#include <doctest/doctest.h>

#include <map>

#include "tests/api/formats/gltf_files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

json external(const json& uri = "x.bin") {
  json document = tetrahedron();
  document["buffers"][0]["uri"] = uri;
  return document;
}

std::string bundle(const std::map<std::string, std::string>& files) {
  std::string out;
  BundleWriter writer([&](std::string_view piece) { return out += piece, true; });
  std::uint64_t bytes = BundleWriter::bytes_for_end();
  for (const auto& [path, content] : files) {
    CHECK(writer.add(path, bytes_of(content)));
    bytes += BundleWriter::bytes_for(path, content.size());
  }
  CHECK(writer.finish());
  CHECK(out.size() == bytes);
  return out;
}

std::string scene_zip(const json& document, std::vector<ZipEntry> more, const std::string& name = "m/s.gltf") {
  more.insert(more.begin(), {name, document.dump()});
  return zip(more);
}

std::string why(const json& document, std::vector<ZipEntry> more = {}) {
  return refusal(scene_zip(document, std::move(more)), "");
}

}  // namespace

TEST_CASE("glTF bundle: the same files give the same bytes, which are read as their glTF") {
  const std::map<std::string, std::string> files{{"buffers/x.bin", tetrahedron_data()},
                                                 {"scene.gltf", external("buffers/x.bin").dump()}};
  const std::string archive = bundle(files);
  CHECK(archive == bundle(files));
  CHECK(archive.starts_with(std::string("PK\x03\x04\x14\0\0\x08\0\0\0\0\x21\0", 14)));
  const auto alone = read(glb(tetrahedron()), "");
  for (const char* name : {"", "scene.gltf", "scene.zip", "scene.gltf.zip"}) {
    const auto read_back = read(archive, name);
    REQUIRE(read_back.ok());
    CHECK(read_back->format == Format::gltf);
    CHECK(!read_back->notes.filename_says);
    CHECK(read_back->mesh.positions == alone->mesh.positions);
    CHECK(read_back->mesh.triangles == alone->mesh.triangles);
  }
  CHECK(read(archive, "scene.3mf")->notes.filename_says == Format::three_mf);
  CHECK(detect_format(bytes_of(archive), {"a", "", "application/zip"}) == Format::gltf);
}

TEST_CASE("glTF bundle: a full sink ends the writing") {
  BundleWriter writer([](std::string_view) { return false; });
  CHECK(!writer.add("a", bytes_of("b")));
}

TEST_CASE("glTF bundle: the files that a document names") {
  const auto named = [](const json& document) { return files_named_by(bytes_of(document.dump())); };
  CHECK(named(external()) == std::vector<std::string>{"x.bin"});
  CHECK(named(tetrahedron()).empty());
  json several = external("b%20c.bin");
  several["buffers"].push_back({{"byteLength", 4}, {"uri", "./a.bin"}});
  several["buffers"].push_back({{"byteLength", 4}, {"uri", "data:application/octet-stream;base64,AAAAAA=="}});
  several["buffers"].push_back({{"byteLength", 4}, {"uri", "a.bin"}});
  several["images"] = json::array({{{"uri", "picture.png"}}});
  CHECK(named(several) == std::vector<std::string>{"a.bin", "b c.bin"});
  several["buffers"].push_back({{"byteLength", 4}, {"uri", "../y.bin"}});  // the reader refuses the document
  CHECK(named(several).empty());
  CHECK(files_named_by(bytes_of("{")).empty());
  CHECK(files_named_by(bytes_of("solid")).empty());
  CHECK(is_gltf_json(bytes_of("\xEF\xBB\xBF \n{}")));
  CHECK(!is_gltf_json(bytes_of("glTF")));
  CHECK(!is_gltf_json(bytes_of("")));
  CHECK(is_scene_path("a/b.GLTF"));
  CHECK(!is_scene_path("gltf"));
}

TEST_CASE("glTF archive: files are looked up from the folder of the .gltf") {
  const std::string data = tetrahedron_data();
  const auto triangles = [&](const json& document, std::vector<ZipEntry> more) {
    return mesh_of(scene_zip(document, std::move(more))).triangles.size();
  };
  CHECK(triangles(external(), {{"m/x.bin", data}, {"x.bin", "another"}, {"m/picture.png", "no picture"}}) == 4);
  CHECK(triangles(external("./sub/a%20b.bin"), {{"m/sub/a b.bin", data, 0}}) == 4);
  CHECK(triangles(external("X.BIN"), {{"M/x.bin", data}}) == 4);  // names in an archive are compared without case
  CHECK(triangles(external(), {{"m/x.bin", data}, {"__MACOSX/m/._s.gltf", "attributes"}}) == 4);
  json twice = external();
  twice["buffers"].push_back({{"byteLength", 72}, {"uri", "x.bin"}});
  twice["bufferViews"][1]["buffer"] = 1;
  CHECK(triangles(twice, {{"m/x.bin", data}}) == 4);
}

TEST_CASE("glTF archive: a file that is missing, short or outside is refused with its name") {
  const std::string data = tetrahedron_data();
  CHECK(contains(
      refusal(external().dump(), "m.gltf"),
      "buffers[0] of 'a': names the file 'x.bin', which was not sent with it: put both into one .zip (or, over HTTP, "
      "send the file as a part 'a.files' or 'b.files')"));
  CHECK(code(external().dump(), "m.gltf") == ErrorCode::unreadable_mesh);
  CHECK(contains(why(external(), {{"x.bin", data}}),
                 "buffers[0] of 'a': names the file 'x.bin', which is not among the files sent with it"));
  CHECK(contains(why(external(), {{"m/x.bin", data.substr(0, 71)}}),
                 "byteLength is 72, but there are 71 bytes of data in 'x.bin'"));
  CHECK(contains(why(external(), {{"m/x.bin", data, 8, 0, 0, 1}}), "m/x.bin of 'a': damaged: its CRC does not match"));
  for (const char* uri : {"../x.bin", "%2e%2e/x.bin", "a/%2E%2E/../x.bin"}) {
    CHECK(contains(why(external(uri), {{"x.bin", data}, {"m/../x.bin", data}}), "has '..'"));
  }
  CHECK(contains(why(external("/etc/passwd"), {{"/etc/passwd", data}}),
                 "buffers[0].uri of 'a': '/etc/passwd' is absolute"));
  json second = external("none.bin");
  second["buffers"].push_back({{"byteLength", 4}, {"uri", "../y.bin"}});
  CHECK(contains(refusal(second.dump(), "m.gltf"), "buffers[1].uri of 'a': '../y.bin' has '..'"));
  CHECK(contains(why(external("file:///etc/passwd")), "has a scheme, and nothing is fetched"));
  CHECK(contains(why(external("http://127.0.0.1:9/x.bin")), "has a scheme, and nothing is fetched"));
}

TEST_CASE("glTF archive: exactly one .gltf") {
  const std::string data = tetrahedron_data();
  CHECK(contains(why(external(), {{"m/x.bin", data}, {"other/t.GLTF", "{}"}}),
                 "'a' is a zip archive with 2 .gltf files; exactly one is allowed"));
  CHECK(contains(refusal(zip({{"s.glb", glb(tetrahedron())}}), ""), "is a zip archive, not a mesh"));
  CHECK(contains(why(external(), {{"_rels/.rels", relationships()}}), "'a'"));  // a package is not a glTF
  CHECK(!contains(why(external(), {{"_rels/.rels", relationships()}}), "x.bin"));
  CHECK(contains(refusal(zip({{"s.gltf", "{"}}), ""), "not valid JSON"));
  const std::string whole = scene_zip(external(), {{"m/x.bin", data}});
  for (std::size_t size = 0; size < whole.size(); ++size) CHECK(!refusal(whole.substr(0, size), "").empty());
}

TEST_CASE("glTF archive: all entries together expand no farther than a file may") {
  json document = external();
  std::vector<ZipEntry> files{{"m/x.bin", tetrahedron_data()}};
  for (int i = 0; i < 5; ++i) {
    const std::string name = "z" + std::to_string(i) + ".bin";
    document["buffers"].push_back({{"byteLength", 1}, {"uri", name}});
    files.push_back({"m/" + name, std::string(std::size_t{20} << 20U, '\0')});
  }
  CHECK(contains(why(document, files), "'a' expands to more than"));
  ReadLimits small;
  small.max_expanded_bytes = 100;
  CHECK(contains(read(scene_zip(external(), {files.front()}), "", small).error().message, "expands to more than 100"));
}

TEST_CASE("glTF archive: a sparse accessor may be larger than its document") {
  json document = external();
  document["buffers"][0]["byteLength"] = 60'000;
  document["accessors"][0] = {{"componentType", 5126}, {"count", 20'000}, {"type", "VEC3"}};
  const std::string data = tetrahedron_data() + std::string(60'000, '\0');
  CHECK(mesh_of(scene_zip(document, {{"m/x.bin", data, 0}})).positions.size() == 20'000);
  document["accessors"][0]["count"] = 10'000'000;
  CHECK(contains(why(document, {{"m/x.bin", data, 0}}), "more than the limit for a file of this size"));
}

}  // namespace meshgauge::api::test
