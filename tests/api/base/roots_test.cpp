#include "api/base/roots.h"

#include <filesystem>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::api;
namespace fs = std::filesystem;

namespace {

Roots roots_of(const std::vector<std::string>& folders) { return Roots::open(folders).value(); }

// The place, or why there is none.
std::string place_in(const Roots& roots, const std::string& path) {
  const auto found = roots.find(path);
  return found ? found->path() : found.error().message;
}

}  // namespace

TEST_CASE("roots: a path that is relative, or absolute below a root") {
  const test::Folder folder;
  folder.write("in/sub/x.stl", "x");
  const std::string in = (folder / "in").string();
  const Roots roots = roots_of({in});
  for (const std::string& path : {std::string("sub/x.stl"), std::string("./sub//x.stl"), in + "/sub/x.stl",
                                  in + "/./sub/./x.stl", "/." + in + "//sub/x.stl"})
    CHECK(place_in(roots, path) == in + "/sub/x.stl");
  CHECK(place_in(roots, "none.stl") == in + "/none.stl");  // opening it says that it is missing
}

TEST_CASE("roots: what leads elsewhere is refused") {
  const test::Folder folder;
  folder.write("in/x.stl", "x");
  folder.write("inner/x.stl", "x");
  const std::string in = (folder / "in").string();
  const Roots roots = roots_of({in});
  for (const char* path : {"..", "../x.stl", "sub/../x.stl", "sub/../../in/x.stl"})
    CHECK(place_in(roots, path) ==
          "the path '" + std::string(path) + "' has '..', which may lead out of the folders that may be read");
  const std::string beside = (folder / "inner/x.stl").string();
  for (const std::string& path : {std::string("/etc/passwd"), beside, in, std::string("/x.stl")})
    CHECK(place_in(roots, path) == "the path '" + path + "' is outside of the folders that may be read: " + in);
  CHECK(place_in(roots, "") == "the path is empty: name a file");
  CHECK(place_in(roots, "./.") == "the path './.' names a folder: name a file in it");
  CHECK(place_in(roots, std::string("x.stl\0", 6)) == "the path 'x.stl?' has a control character");
  CHECK(place_in(roots, "x\n.stl") == "the path 'x?.stl' has a control character");
}

TEST_CASE("roots: of several the first that has the file, each by its own spelling") {
  const test::Folder folder;
  folder.write("one/x.stl", "x");
  folder.write("two/x.stl", "x");
  folder.write("two/y.stl", "x");
  fs::create_directory_symlink(folder / "two", folder / "link");
  const std::string one = (folder / "one").string(), two = (folder / "two").string(), link = (folder / "link").string();
  const Roots roots = roots_of({one, link});
  CHECK(roots.folders() == std::vector<std::string>{one, two});
  CHECK(place_in(roots, "x.stl") == one + "/x.stl");
  CHECK(place_in(roots, "y.stl") == two + "/y.stl");
  CHECK(place_in(roots, "z.stl") == one + "/z.stl");
  CHECK(place_in(roots, two + "/x.stl") == two + "/x.stl");
  CHECK(place_in(roots, link + "/x.stl") == two + "/x.stl");
}

TEST_CASE("roots: '..' behind a link leads where the system goes, and only there") {
  const test::Folder folder;
  folder.write("far/one/x.stl", "x");
  folder.write("y.stl", "x");
  fs::create_directory_symlink(folder / "far/one", folder / "link");
  const std::string far = (folder / "far").string();
  const Roots roots = roots_of({(folder / "link/..").string()});
  CHECK(roots.folders() == std::vector<std::string>{far});
  CHECK(place_in(roots, far + "/one/x.stl") == far + "/one/x.stl");
  CHECK(place_in(roots, (folder / "y.stl").string()).find("is outside of the folders") != std::string::npos);
}

TEST_CASE("roots: a root must be a folder") {
  const test::Folder folder;
  const std::string file = folder.write("x.stl", "x").string(), none = (folder / "none").string();
  for (const std::string& path : {file, none})
    CHECK(Roots::open({path}).error().message == "'" + path + "' is no folder that can be read");
  const test::Inside inside(folder.path());
  CHECK(place_in(roots_of({"."}), "x.stl") == file);
}
