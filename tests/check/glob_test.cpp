#include "check/manifest/glob.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;

namespace {

// "path (dir)" of each match.
std::vector<std::string> found(const Folder& folder, const std::string& pattern) {
  REQUIRE_MESSAGE(check_glob(pattern).ok(), pattern);
  const auto matches = glob(folder.path(), pattern);
  REQUIRE_MESSAGE(matches.ok(), pattern);
  std::vector<std::string> out;
  for (const Match& match : *matches) out.push_back(match.path + (match.dir.empty() ? "" : " (" + match.dir + ")"));
  return out;
}

using List = std::vector<std::string>;

}  // namespace

TEST_CASE("glob: wildcards within a name") {
  const Folder folder;
  for (const char* name : {"b/x_1.stl", "b/x_2.stl", "b/x_10.stl", "b/y.STL", "b/\xC3\xA4.stl", "b/.hidden.stl",
                           "b/a[1].stl", "b/sub/x_3.stl"}) {
    folder.write(name, "");
  }
  CHECK(found(folder, "b/x_*.stl") == List{"b/x_1.stl", "b/x_10.stl", "b/x_2.stl"});
  CHECK(found(folder, "b/x_?.stl") == List{"b/x_1.stl", "b/x_2.stl"});
  CHECK(found(folder, "b/x_[2-9].stl") == List{"b/x_2.stl"});
  CHECK(found(folder, "b/x_[!2].stl") == List{"b/x_1.stl"});
  CHECK(found(folder, "b/?.stl") == List{"b/\xC3\xA4.stl"});
  CHECK(found(folder, "b/a[[]1].stl") == List{"b/a[1].stl"});
  CHECK(found(folder, "b/.h*") == List{"b/.hidden.stl"});
  CHECK(found(folder, "./b//y.*") == List{"./b/y.STL"});
  CHECK(found(folder, "c/*").empty());
  CHECK(found(folder, "b/y.STL/*").empty());
  CHECK(found(folder, "b/s*").empty());  // a folder is no match
}

TEST_CASE("glob: folders between, and what lies below the first wildcard") {
  const Folder folder;
  for (const char* name : {"b/x.stl", "b/near/x.stl", "b/near/by/x.stl", "b/far/by/x.stl", "b/.git/x.stl", "x.stl"})
    folder.write(name, "");
  CHECK(found(folder, "b/**/x.stl") ==
        List{"b/far/by/x.stl (far/by)", "b/near/by/x.stl (near/by)", "b/near/x.stl (near)", "b/x.stl"});
  CHECK(found(folder, "b/**/by/*") == List{"b/far/by/x.stl (far/by)", "b/near/by/x.stl (near/by)"});
  CHECK(found(folder, "b/*/x.stl") == List{"b/near/x.stl (near)"});
  CHECK(found(folder, "b/n*/by/x.stl") == List{"b/near/by/x.stl (near/by)"});
  CHECK(found(folder, "**/**/x.stl").size() == 5);
  CHECK(found(folder, "b/near/**") == List{"b/near/by/x.stl (by)", "b/near/x.stl"});
  CHECK(found(folder, folder.path().string() + "/*.stl") == List{folder.path().string() + "/x.stl"});
}

TEST_CASE("glob: links to files are files, links to folders are not searched") {
  const Folder folder;
  folder.write("b/x.stl", "");
  folder.write("elsewhere/y.stl", "");
  std::filesystem::create_directory_symlink(".", folder / "b/circle");
  std::filesystem::create_directory_symlink("../elsewhere", folder / "b/out");
  std::filesystem::create_symlink("x.stl", folder / "b/link.stl");
  std::filesystem::create_symlink("gone.stl", folder / "b/lost.stl");
  CHECK(found(folder, "b/**/*.stl") == List{"b/link.stl", "b/lost.stl", "b/x.stl"});
  CHECK(found(folder, "b/out/*.stl") == List{"b/out/y.stl"});  // by name it may be
}

TEST_CASE("glob: a folder that cannot be read is an error") {
  const meshgauge::api::test::Folder folder;
  folder.write("a/in/x.stl", "x");
  std::filesystem::create_directory(folder / "b");
  std::filesystem::create_directory_symlink("in", folder / "b/in");  // to itself
  for (const char* pattern : {"*/in/*.stl", "b/*/x.stl"}) {
    CAPTURE(pattern);
    const auto found = glob(folder.path(), pattern);
    REQUIRE(!found.ok());
    CHECK(found.error().message.starts_with("cannot be looked up: '"));
  }
}

TEST_CASE("glob: a malformed pattern is refused") {
  for (const char* pattern : {"b/*/", "a**", "**.stl", "b/***", "[", "x[a", "x[]", "x[!]", "a[b]/c[d"}) {
    CAPTURE(pattern);
    CHECK(!check_glob(pattern).ok());
  }
  for (const char* pattern : {"[]]", "[!]]", "[[]", "x[a]y[b]", "**", "**/x", "x]"}) {
    CAPTURE(pattern);
    CHECK(check_glob(pattern).ok());
  }
}

TEST_CASE("glob: the number of files is limited") {
  const Folder folder;
  for (std::size_t i = 0; i <= kMaxGlobMatches; ++i) folder.write(std::to_string(i), "");
  const auto matches = glob(folder.path(), "*");
  REQUIRE(!matches.ok());
  CHECK(matches.error().message == "finds more than 10000 files");
}
