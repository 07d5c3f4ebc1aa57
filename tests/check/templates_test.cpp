#include "check/revision/templates.h"

#include <string>

#include <doctest/doctest.h>

#include "check/manifest/glob.h"

using namespace meshgauge::check;

namespace {

// Whether a path of the revision matches the pattern, whose fixed folder lies there in the repository.
bool matching(const std::string& pattern, const std::string& folder, const std::string& path) {
  const Utf8Locale utf8;
  const OpenBaselines baselines{{}, ".", pattern, ""};
  Templates templates;
  templates.add(baselines, folder);
  const OpenBaselines* found = templates.matching(path);
  CHECK((found == nullptr || found == &baselines));
  return found != nullptr;
}

}  // namespace

TEST_CASE("templates: the folder before the first wildcard") {
  CHECK(fixed_folder("base/a/*.stl") == "base/a");
  CHECK(fixed_folder("*.stl") == "");
  CHECK(fixed_folder("part.stl") == "");
  CHECK(fixed_folder("/base/part.stl") == "/base");
  CHECK(fixed_folder("../base/[[]x/*.stl") == "../base/[x");
  CHECK(fixed_folder("base/[xy]/*.stl") == "base");
}

TEST_CASE("templates: paths of a revision match as files do, other spellings included") {
  CHECK(matching("base/*.stl", "base/", "base/x.stl"));
  CHECK(matching("base/*.stl", "sub/base/", "sub/base/x.stl"));
  CHECK(matching("base/*.stl", "[1]/base/", "[1]/base/x.stl"));
  CHECK(matching("base/*.stl", "base/", "Base/x.STL"));
  CHECK(matching("*.stl", "", "x.stl"));
  CHECK(matching("**/x-*.stl", "", "a/b/x-1.stl"));
  CHECK(matching("a/**/../golden/*.stl", "a/", "a/b/c/golden/x.stl"));
  CHECK(matching("a/*/../golden/*.stl", "a/", "a/golden/x.stl"));
  CHECK_FALSE(matching("a/*/../golden/*.stl", "a/", "a/b/golden/x.stl"));
  CHECK(matching("a/**/../golden/*.stl", "a/", "golden/x.stl"));
  CHECK(matching("a/*/../../golden/*.stl", "a/", "golden/x.stl"));
  CHECK_FALSE(matching("a/*/../../golden/*.stl", "a/", "a/golden/x.stl"));
  CHECK_FALSE(matching("a/*/../../../golden/*.stl", "a/", "golden/x.stl"));
  std::string many = "a/";
  for (int i = 0; i < 100; ++i) many += "**/b/../../";
  CHECK(matching(many + "*.stl", "a/", "any/x.stl"));
  CHECK(matching("base/*.stl", "base/", "base /x.stl"));
  CHECK(matching("*.stl", "**/**/**/", "**/**/**/x.stl"));
  CHECK_FALSE(matching("base/*.stl", "base/", "base/.x.stl"));
  CHECK_FALSE(matching("base/*.stl", "base/", "base/deep/x.stl"));
  CHECK_FALSE(matching("base/*.stl", "base/", "other/base/x.stl"));
  CHECK_FALSE(matching("base/*.stl", "base/", "x.stl"));
  CHECK_FALSE(matching("base/*/..", "base/", "base/x"));
}

TEST_CASE("templates: of many, each folder has its own") {
  const Utf8Locale utf8;
  const OpenBaselines one{{}, ".", "a/*.stl", ""}, other{{}, ".", "a/b/*.stl", ""};
  Templates templates;
  templates.add(one, "a/");
  templates.add(other, "a/b/");
  for (int i = 0; i < 2; ++i) {
    CHECK(templates.matching("a/x.stl") == &one);
    CHECK(templates.matching("a/b/x.stl") == &other);
    CHECK(templates.matching("x.stl") == nullptr);
    CHECK(templates.matching("a/b/c/x.stl") == nullptr);
  }
}
