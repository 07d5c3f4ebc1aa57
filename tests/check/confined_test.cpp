// A manifest that is read for a client that is not trusted.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "api/base/whole_file.h"
#include "check/manifest/glob.h"
#include "check/manifest/manifest.h"
#include "check/run/meshes.h"
#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;

namespace {

using Said = std::vector<std::string>;

std::shared_ptr<const api::Confines> within(const Folder& folder, const std::string& root) {
  return std::make_shared<const api::Confines>(api::Confines{api::Roots::open({(folder / root).string()}).value()});
}

std::string one_gate(const std::string& candidate, const std::string& baseline) {
  return "version: 1\ngates: [{name: '{stem}', candidate: '" + candidate + "', baseline: '" + baseline +
         "', max_distance: 1, unmatched_baselines: ignore}]\n";
}

// What is wrong with a manifest of this gate in the folder "in", the only root.
Said said_of(const Folder& folder, const std::string& candidate, const std::string& baseline) {
  folder.write("in/gates.yaml", one_gate(candidate, baseline));
  Said said;
  for (const Mistake& mistake : defects_of(gates_within(within(folder, "in"), "gates.yaml")))
    said.push_back(mistake.message);
  return said;
}

bool contain(const Said& said, const std::string& words) {
  for (const std::string& one : said) {
    if (one.find(words) != std::string::npos) return true;
  }
  return false;
}

Folder& furnished(Folder& folder) {
  for (const char* name : {"in/parts/x.off", "in/base/x.off", "out/x.off", "out/secret.off"})
    folder.write(name, api::test::small_mesh());
  return folder;
}

}  // namespace

TEST_CASE("confined: the files below the manifest's folder are read, whatever the current folder is") {
  Folder folder;
  furnished(folder).write("in/gates.yaml", one_gate("parts/*.off", "base/{stem}.off"));
  for (const char* here : {"", "in", "in/parts", "out"}) {
    const Inside inside(folder / here);
    const auto read = gates_within(within(folder, "in"), "gates.yaml");
    REQUIRE(defects_of(read).empty());
    REQUIRE(read.gates.size() == 1);
    Meshes meshes(read.gates);
    Control control;
    CHECK(meshes.get(read.gates[0].candidate, control).ok());
    CHECK(meshes.get(read.gates[0].baseline, control).ok());
  }
}

TEST_CASE("confined: absolute paths and '..' are mistakes, and nothing is looked up there") {
  Folder folder;
  furnished(folder);
  const std::string out = (folder / "out").string();
  for (const std::string& path : {std::string("../out/x.off"), std::string("../out/*.off"), out + "/x.off",
                                  out + "/*.off", std::string("parts/../parts/x.off"), std::string("/**/secret.off")}) {
    const Said said = said_of(folder, path, "base/x.off");
    REQUIRE(said.size() == 1);
    CHECK(said[0].find("may lead out of the folders that may be read") != std::string::npos);
  }
  CHECK(contain(said_of(folder, "parts/x.off", "../out/x.off"), "may lead out"));
}

TEST_CASE("confined: symbolic links are not followed") {
  namespace fs = std::filesystem;
  Folder folder;
  furnished(folder);
  fs::create_directory_symlink(folder / "out", folder / "in/link");
  fs::create_symlink(folder / "out/x.off", folder / "in/parts/y.off");
  const std::string why = "is a symbolic link or lies behind one, which is not followed";
  CHECK(contain(said_of(folder, "parts/y.off", "base/x.off"), why));
  CHECK(contain(said_of(folder, "parts/*.off", "base/x.off"), why));
  CHECK(contain(said_of(folder, "link/x.off", "base/x.off"), why));
  CHECK(contain(said_of(folder, "parts/x.off", "link/x.off"), why));
  for (const char* pattern : {"link/*.off", "*/secret.off", "l*/*.off"}) {
    const Said said = said_of(folder, pattern, "base/x.off");
    CHECK(contain(said, "/in/link', which is not followed"));
    CHECK_FALSE(contain(said, "link/secret.off"));
  }
  // What differs by case is not looked for behind a link, either.
  CHECK_FALSE(contain(said_of(folder, "Link/SECRET.off", "base/x.off"), "link/secret.off"));
  CHECK_FALSE(contain(said_of(folder, "LINK/*.OFF", "base/x.off"), "link/secret.off"));
  CHECK_FALSE(contain(said_of(folder, "**/x.off", "base/x.off"), "/in/link"));  // which "**" passes by everywhere
}

TEST_CASE("confined: a backslash in place of a slash leads nowhere, either") {
  Folder folder;
  furnished(folder).write("in/parts/x.OFF", api::test::small_mesh());
  for (const char* pattern : {"..\\out\\*.off", "..\\out\\secret.of?", "parts\\..\\..\\out\\*.off"}) {
    const Said said = said_of(folder, pattern, "base/x.off");
    CHECK_FALSE(said.empty());
    CHECK_FALSE(contain(said, "secret.off"));
  }
}

TEST_CASE("confined: folders are listed below the root that was opened, whatever is in its place") {
  namespace fs = std::filesystem;
  Folder folder;
  furnished(folder).write("in/gates.yaml", one_gate("parts/*.off", "base/{stem}.off"));
  folder.write("out/gates.yaml", one_gate("*.off", "x.off"));
  const auto confines = within(folder, "in");
  fs::rename(folder / "in", folder / "moved");
  fs::create_directory_symlink(folder / "out", folder / "in");
  const auto read = gates_within(confines, "gates.yaml");
  CHECK(defects_of(read).empty());
  REQUIRE(read.gates.size() == 1);
  CHECK(read.gates[0].name == "x");
  CHECK(read.gates[0].candidate.filename() == "x.off");
}

TEST_CASE("confined: what looks for files ends when it is interrupted, and the manifest is not run") {
  Folder folder;
  furnished(folder).write("in/gates.yaml", one_gate("parts/*.off", "base/{stem}.off"));
  const auto read = gates_within(within(folder, "in"), "gates.yaml", {}, [] { return true; });
  Said said;
  for (const Mistake& mistake : read.mistakes) said.push_back(mistake.message);
  CHECK(contain(said, "cannot be looked up: the time for it is over"));
  CHECK(contain(said, "the time was over before all files of the manifest were found"));
}

TEST_CASE("confined: all globs of a manifest together look at so many files") {
  Folder folder;
  furnished(folder);
  auto held = api::open_folder_below({(folder / "in").string()}, "");
  REQUIRE(held.ok());
  GlobConfines confines{
      {(folder / "in").string(), std::make_shared<const Descriptor>(std::move(*held))}, never_interrupted, 3};
  const std::filesystem::path here = folder / "in";
  CHECK(glob(here, "parts/*.off", &confines).value().size() == 1);
  CHECK(glob(here, "base/*.off", &confines).value().size() == 1);
  CHECK(confines.entries_left == 1);
  CHECK(glob(here, "parts/*.off", &confines).ok());
  CHECK(glob(here, "base/*.off", &confines).error().message.find("looks at more than") != std::string::npos);
}

TEST_CASE("confined: the manifest itself is below a root") {
  namespace fs = std::filesystem;
  Folder folder;
  furnished(folder).write("out/gates.yaml", one_gate("x.off", "secret.off"));
  fs::create_symlink(folder / "out/gates.yaml", folder / "in/link.yaml");
  const auto first = [&](const std::string& path) {
    return gates_within(within(folder, "in"), path).mistakes.at(0).message;
  };
  CHECK(first((folder / "out/gates.yaml").string()).find("is outside of the folders") != std::string::npos);
  CHECK(first("../out/gates.yaml").find("has '..'") != std::string::npos);
  CHECK(first("link.yaml").find("is a symbolic link") != std::string::npos);
  CHECK(first("none.yaml").find("No such file or directory") != std::string::npos);
  CHECK(first("parts").find("is a folder") != std::string::npos);
}

TEST_CASE("confined: a file that becomes a link after the manifest was read is not followed") {
  namespace fs = std::filesystem;
  Folder folder;
  furnished(folder).write("in/gates.yaml", one_gate("parts/x.off", "base/x.off"));
  const auto read = gates_within(within(folder, "in"), "gates.yaml");
  REQUIRE(defects_of(read).empty());
  Meshes meshes(read.gates);
  fs::remove(folder / "in/parts/x.off");
  fs::create_symlink(folder / "out/secret.off", folder / "in/parts/x.off");
  Control control;
  const auto mesh = meshes.get(read.gates[0].candidate, control);
  CHECK(mesh.error().message.find("is a symbolic link") != std::string::npos);
}
