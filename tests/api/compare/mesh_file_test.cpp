#include "api/compare/mesh_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "api/formats/format.h"
#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::api;
namespace fs = std::filesystem;

namespace {

// One triangle, whose three vertices are in the file of this URI.
std::string scene(const std::string& uri) {
  return R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": ")" +
         uri + "\"}]}";
}

std::string corners() {
  std::string data(36, '\0');
  data[4 * 3 + 2] = data[4 * 7 + 2] = '\x80';  // (0 0 0) (1 0 0) (0 1 0)
  data[4 * 3 + 3] = data[4 * 7 + 3] = '\x3F';
  return data;
}

// The number of triangles, or why there is none.
std::string told(const fs::path& path) {
  const auto file = MeshFile::open(path.string());
  if (!file) return file.error().message;
  const auto mesh = api::read_mesh(file->bytes(), {"a", path.filename().string(), ""}, api::ReadLimits{});
  return mesh ? std::to_string(mesh->mesh.triangles.size()) : mesh.error().message;
}

std::string told_with(const test::Folder& folder, const std::string& uri) {
  return told(folder.write("in/s.gltf", scene(uri)));
}

bool contains(const std::string& text, const std::string& piece) { return text.find(piece) != std::string::npos; }

}  // namespace

TEST_CASE("mesh file: a .gltf with the files that it names, from its folder and below") {
  const test::Folder folder;
  folder.write("in/x y.bin", corners());
  folder.write("in/sub/x.bin", corners());
  CHECK(told_with(folder, "x%20y.bin") == "1");
  CHECK(told_with(folder, "./sub//x.bin") == "1");
  const test::Inside inside(folder / "in");
  CHECK(told("s.gltf") == "1");
  fs::create_directory_symlink(folder / "in", folder / "link");  // named by the user, so it is followed
  CHECK(told(folder / "link/s.gltf") == "1");
  const auto one = MeshFile::open("s.gltf"), two = MeshFile::open((folder / "link/s.gltf").string());
  CHECK(std::ranges::equal(one->bytes(), two->bytes()));
  CHECK(one->media_type() == "application/zip");
  CHECK(one->more_suffix() == ".zip");
}

TEST_CASE("mesh file: another file is its bytes") {
  const test::Folder folder;
  const auto plain = MeshFile::open(folder.write("m.off", test::small_mesh()).string());
  CHECK(plain->bytes().size() == test::small_mesh().size());
  CHECK(plain->media_type() == "application/octet-stream");
  CHECK(plain->more_suffix().empty());
  CHECK(contains(told(folder.write("m.gltf", "{")), "not valid JSON"));
  CHECK(contains(told(folder.write("n.gltf", scene("data:,"))), "data URI"));
}

TEST_CASE("mesh file: nothing outside of the folder of a .gltf is opened") {
  const test::Folder folder;
  const std::string outside = folder.write("x.bin", corners()).string();
  folder.write("in/sub/x.bin", corners());
  fs::create_symlink(outside, folder / "in/link.bin");
  fs::create_symlink("sub/x.bin", folder / "in/inner.bin");  // a link within the folder is one as well
  fs::create_directory_symlink(folder.path(), folder / "in/up");
  fs::create_symlink("/dev/zero", folder / "in/zero.bin");
  for (const char* uri : {"../x.bin", "sub/../../x.bin", "%2e%2e/x.bin", "%2E%2E%2Fx.bin", "./%2e./x.bin"}) {
    CHECK(contains(told_with(folder, uri), "has '..'"));
  }
  CHECK(contains(told_with(folder, outside), "is absolute"));
  CHECK(contains(told_with(folder, "%2Fdev%2Fzero"), "is absolute"));
  CHECK(contains(told_with(folder, "file://" + outside), "has a scheme, and nothing is fetched"));
  CHECK(contains(told_with(folder, "http://127.0.0.1:9/x.bin"), "has a scheme, and nothing is fetched"));
  CHECK(contains(told_with(folder, "..\\\\x.bin"), "has a backslash"));
  for (const char* uri : {"link.bin", "inner.bin", "up/x.bin", "zero.bin"}) {
    const std::string why = told_with(folder, uri);
    CHECK(contains(why, "/in/s.gltf' is a glTF of several files: '"));
    CHECK(contains(why, std::string("/in/") + uri + "' is a symbolic link or lies behind one, which is not followed"));
  }
}

TEST_CASE("mesh file: within roots no link is followed, not for the file and not for those that it names") {
  const test::Folder folder;
  folder.write("out/x.bin", corners());
  folder.write("out/m.off", test::small_mesh());
  folder.write("in/sub/x.bin", corners());
  folder.write("in/sub/m.off", test::small_mesh());
  folder.write("in/sub/s.gltf", scene("x.bin"));
  folder.write("in/sub/up.gltf", scene("../x.bin"));
  folder.write("in/sub/link.gltf", scene("link.bin"));
  fs::create_symlink(folder / "out/x.bin", folder / "in/sub/link.bin");
  fs::create_symlink(folder / "out/m.off", folder / "in/link.off");
  fs::create_symlink("sub/m.off", folder / "in/inner.off");
  fs::create_directory_symlink(folder / "out", folder / "in/folder");
  const Confines confines{Roots::open({(folder / "in").string()}).value()};
  const auto said = [&](const std::string& path) {
    const auto file = MeshFile::open_within(confines, path);
    if (!file) return file.error().message;
    const auto mesh = api::read_mesh(file->bytes(), {"a", path, ""}, confines.limits);
    return mesh ? std::to_string(mesh->mesh.triangles.size()) : mesh.error().message;
  };
  CHECK(said("sub/m.off") == "1");
  CHECK(said((folder / "in/sub/m.off").string()) == "1");
  CHECK(said("sub/s.gltf") == "1");
  CHECK(contains(said("sub/up.gltf"), "has '..'"));
  for (const char* path : {"link.off", "inner.off", "folder/m.off", "sub/link.gltf"})
    CHECK(contains(said(path), "is a symbolic link or lies behind one, which is not followed"));
  CHECK(contains(said((folder / "out/m.off").string()), "is outside of the folders that may be read"));
  CHECK(contains(said("sub"), "/in/sub' is a folder: name a file in it"));
  CHECK(contains(said("none.off"), "/in/none.off' cannot be read: No such file or directory"));
}

TEST_CASE("mesh file: within roots a file has at most so many bytes") {
  const test::Folder folder;
  folder.write("m.off", test::small_mesh());
  const Confines confines{Roots::open({folder.path().string()}).value(), {}, test::small_mesh().size() - 1};
  const auto file = MeshFile::open_within(confines, "m.off");
  CHECK(contains(file.error().message, "m.off' is larger than the"));
  CHECK(file.error().code == ErrorCode::too_large);
}

TEST_CASE("mesh file: within roots a .gltf has at most so many bytes with the files that it names") {
  const test::Folder folder;
  const std::string text = scene("x.bin");
  folder.write("s.gltf", text);
  folder.write("x.bin", corners());
  Confines confines{Roots::open({folder.path().string()}).value()};
  const auto code = [&](std::uint64_t most) {
    confines.max_file_bytes = most;
    const auto file = MeshFile::open_within(confines, "s.gltf");
    return file ? "read" : file.error().code == ErrorCode::too_large ? "too large" : "another error";
  };
  CHECK(code(text.size() + corners().size() - 1) == std::string("too large"));
  CHECK(code(text.size()) == std::string("too large"));
  CHECK(code(text.size() + corners().size() + 4096) == std::string("read"));  // with the heads of an archive
}

TEST_CASE("mesh file: within roots all files that are held have at most so many bytes together") {
  const test::Folder folder;
  folder.write("m.off", test::small_mesh());
  folder.write("s.gltf", scene("x.bin"));
  folder.write("x.bin", corners());
  Confines confines{Roots::open({folder.path().string()}).value()};
  confines.files = std::make_shared<ByteBudget>(2 * test::small_mesh().size());
  const auto opened = [&](const char* path) { return MeshFile::open_within(confines, path); };
  {
    const auto one = opened("m.off"), two = opened("m.off");
    CHECK(one.ok());
    CHECK(two.ok());
    CHECK(contains(opened("m.off").error().message, "'m.off' does not fit into memory beside the other files"));
  }
  CHECK(opened("m.off").ok());
  confines.files = std::make_shared<ByteBudget>(scene("x.bin").size());
  CHECK(contains(opened("s.gltf").error().message, "does not fit into memory"));
}

TEST_CASE("mesh file: a root that is moved away stays the root, whatever is put in its place") {
  const test::Folder folder;
  folder.write("in/m.off", test::small_mesh());
  folder.write("out/m.off", test::small_mesh());
  folder.write("out/secret.off", test::small_mesh());
  const Confines confines{Roots::open({(folder / "in").string()}).value()};
  fs::rename(folder / "in", folder / "moved");
  fs::create_directory_symlink(folder / "out", folder / "in");
  CHECK(contains(MeshFile::open_within(confines, "secret.off").error().message, "No such file"));
  fs::remove(folder / "out/m.off");
  CHECK(MeshFile::open_within(confines, "m.off").ok());
  CHECK(MeshFile::open_within(confines, (folder / "in/m.off").string()).ok());
}

TEST_CASE("mesh file: anything but a regular file is refused without blocking") {
  const test::Folder folder;
  fs::create_directories(folder / "in/folder.bin");
  REQUIRE(::mkfifo((folder / "in/pipe.bin").c_str(), 0600) == 0);
  CHECK(contains(told_with(folder, "pipe.bin"), "/in/pipe.bin' is not a regular file"));
  CHECK(contains(told_with(folder, "folder.bin"), "/in/folder.bin' is a folder"));
  CHECK(contains(told_with(folder, "none.bin"), "/in/none.bin' cannot be read: No such file or directory"));
  CHECK(contains(told_with(folder, "pipe.bin/x.bin"), "cannot be read: Not a directory"));
  // Only root may make a device, and not in every container.
  if (::mknod((folder / "in/null.bin").c_str(), S_IFCHR | 0600, makedev(1, 3)) == 0) {
    const std::string why = told_with(folder, "null.bin");
    CHECK((contains(why, "is not a regular file") || contains(why, "Permission denied")));
  }
  const fs::path pipe = folder / "pipe.gltf";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(contains(told(pipe), "is not a regular file"));
}

TEST_CASE("mesh file: bounds of what a .gltf may name") {
  const test::Folder folder;
  std::string many = R"({"asset": {"version": "2.0"}, "buffers": [)";
  for (int i = 0; i < 65; ++i)
    many += (i > 0 ? ", " : "") + (R"({"byteLength": 1, "uri": "x)" + std::to_string(i) + "\"}");
  CHECK(contains(told(folder.write("many.gltf", many + "]}")), "it names 65 files (limit 64)"));
  CHECK(contains(told_with(folder, "scene.gltf"), "a buffer names 'scene.gltf', a .gltf; name a file of binary data"));
  folder.write("in/large.bin", "");
  fs::resize_file(folder / "in/large.bin", std::uintmax_t{5} << 30U);  // of no blocks
  CHECK(contains(told_with(folder, "large.bin"), "large.bin' is larger than the"));
}

TEST_CASE("mesh file: what a pipe sent, under its name") {
  const test::Folder folder;
  const test::Inside inside(folder.path());
  folder.write("x.bin", corners());
  const auto opened = [&](const std::string& sent) {
    Pipes pipes;
    MemoryFile file;
    const Descriptor stream(::open(folder.write("sent", sent).c_str(), O_RDONLY | O_CLOEXEC));
    REQUIRE(MemoryFile::read_all(stream.get(), sent.size(), file) == MemoryFile::End::whole);
    pipes.emplace("standard input", std::move(file));
    const auto mesh = MeshFile::open("standard input", &pipes);
    if (!mesh) return mesh.error().message;
    CHECK(mesh->media_type() == "application/octet-stream");
    CHECK(mesh->more_suffix().empty());
    CHECK(contains(MeshFile::open("none", &pipes).error().message, "'none' cannot be read"));
    return std::string(reinterpret_cast<const char*>(mesh->bytes().data()), mesh->bytes().size());
  };
  CHECK(opened(test::small_mesh()) == test::small_mesh());
  CHECK(opened(scene("data:,")) == scene("data:,"));
  CHECK(
      opened(scene("x.bin")) ==
      "'standard input' is a glTF of several files: it came through a pipe, which has no folder for 'x.bin'; name the "
      ".gltf itself, or send a .glb or a .zip with all files");
}

TEST_CASE("mesh file: a copy stands in place of a file, with the files beside it, and has its name in messages") {
  const test::Folder folder;
  const std::string text = test::small_mesh();
  const Copies copies{{"main:part.off", folder.write("part", text).string()},
                      {"main:scene.gltf", folder.write("0/scene.gltf", scene("x.bin")).string()},
                      {"main:gone.off", (folder / "gone").string()}};
  const auto opened = [&](const std::string& name) { return MeshFile::open(name, nullptr, &copies); };
  REQUIRE(opened("main:part.off"));
  CHECK(opened("main:part.off")->bytes().size() == text.size());
  CHECK(contains(opened("main:scene.gltf").error().message, "'main:scene.gltf' is a glTF of several files: "));
  folder.write("0/x.bin", corners());
  REQUIRE(opened("main:scene.gltf"));
  CHECK(opened("main:scene.gltf")->more_suffix() == ".zip");
  CHECK(opened("main:gone.off").error().message == "'main:gone.off' cannot be read: No such file or directory");
  CHECK(contains(opened("main:other.off").error().message, "'main:other.off' cannot be read"));
}
