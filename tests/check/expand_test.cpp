// Files on a disk that tests/check/manifests cannot have: links, gzip, other folders.
#include "check/manifest/manifest.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;

namespace {

using List = std::vector<std::string>;

std::string manifest(const std::string& name, const std::string& candidate, const std::string& baseline) {
  return "version: 1\ngates:\n- name: '" + name + "'\n  candidate: '" + candidate + "'\n  baseline: '" + baseline +
         "'\n  max_distance: 1\n";
}

List mistakes(const std::filesystem::path& file, Baselines baselines = Baselines::must_exist) {
  List out;
  for (const Mistake& mistake : defects_of(gates_of(file, baselines)))
    out.push_back(to_string(file.filename().string(), mistake));
  return out;
}

bool holds(const List& list, const std::string& words) {
  for (const std::string& line : list) {
    if (line.find(words) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("expand: a compressed file has the stem of what is in it") {
  const Folder folder;
  folder.write("build/part.stl.gz", "x");
  folder.write("base/part.stl", "x");
  const auto read = gates_of(folder.write("gates.yaml", manifest("{stem} of {name}", "build/*.gz", "base/{stem}.stl")));
  REQUIRE(read.mistakes.empty());
  REQUIRE(read.gates.size() == 1);
  CHECK(read.gates[0].name == "part of part.stl.gz");
}

TEST_CASE("expand: paths are relative to the manifest, and shown from the current folder") {
  const Folder folder;
  folder.write("ci/parts/x.stl", "x");
  folder.write("base/x.stl", "y");
  const auto file = folder.write("ci/gates.yaml", manifest("x", "parts/x.stl", "../base/x.stl"));
  const auto paths = [](const std::filesystem::path& from) {
    const auto read = gates_of(from);
    REQUIRE(read.mistakes.empty());
    return read.gates.at(0).candidate.string() + " " + read.gates.at(0).baseline.string();
  };
  const Inside inside(folder.path());
  CHECK(paths("ci/gates.yaml") == "ci/parts/x.stl base/x.stl");
  CHECK(paths("./ci/gates.yaml") == "ci/parts/x.stl base/x.stl");
  CHECK(paths(file) == "ci/parts/x.stl base/x.stl");  // absolute, and below the current folder
  const Inside there(folder / "ci");
  CHECK(paths("gates.yaml") == "parts/x.stl ../base/x.stl");
  const Inside elsewhere(folder / "base");
  CHECK(paths(file) == (folder / "ci/parts/x.stl").string() + " x.stl");
}

TEST_CASE("expand: a path relative to the current folder gets a hint") {
  const Folder folder;
  folder.write("parts/x.stl", "x");
  folder.write("base/x.stl", "y");
  folder.write("ci/gates.yaml", manifest("x", "parts/x.stl", "base/x.stl"));
  const Inside inside(folder.path());
  const List said = mistakes("ci/gates.yaml");
  REQUIRE(said.size() == 2);
  CHECK(said[0] ==
        "gates.yaml:4:14: gate 'x': the candidate 'ci/parts/x.stl' does not exist; it does in the current folder, but "
        "paths are relative to the manifest's");
  CHECK(said[1].find("does not exist; it does in the current folder") != std::string::npos);
}

TEST_CASE("expand: a candidate is not its own baseline, by whatever name") {
  const Folder folder;
  folder.write("x.stl", "x");
  std::filesystem::create_symlink("x.stl", folder / "link.stl");
  std::filesystem::create_hard_link(folder / "x.stl", folder / "hard.stl");
  std::filesystem::create_directory_symlink(".", folder / "here");
  for (const char* baseline : {"x.stl", "./x.stl", "link.stl", "hard.stl", "here/x.stl", "here/../x.stl"}) {
    CAPTURE(baseline);
    const auto file = folder.write("gates.yaml", manifest("x", "x.stl", baseline));
    CHECK(holds(mistakes(file), "gates.yaml:5:13: gate 'x': the baseline '"));
    CHECK(holds(mistakes(file), "is the candidate itself: the gate would always pass"));
  }
  const auto glob = folder.write("gates.yaml", manifest("{stem}", "*.stl", "{name}"));
  CHECK(mistakes(glob).size() == 3);
  const auto missing = folder.write("gates.yaml", manifest("x", "gone.stl", "./gone.stl"));
  CHECK(holds(mistakes(missing, Baselines::may_be_missing), "is the candidate itself"));
}

TEST_CASE("expand: a missing baseline is a mistake, unless it is to be made") {
  const Folder folder;
  folder.write("x.stl", "x");
  const auto file = folder.write("gates.yaml", manifest("x", "x.stl", "base/x.stl"));
  CHECK(holds(mistakes(file), "does not exist; when the candidate is right, make it one by --update-baselines"));
  CHECK(mistakes(file, Baselines::may_be_missing).empty());
  std::filesystem::create_directories(folder / "base/x.stl");
  CHECK(holds(mistakes(file, Baselines::may_be_missing), "is a folder"));
  std::filesystem::remove_all(folder / "base/x.stl");
  std::filesystem::create_symlink("gone.stl", folder / "base/x.stl");
  CHECK(holds(mistakes(file, Baselines::may_be_missing), "does not exist"));  // a link to nothing is in the way
}

TEST_CASE("expand: a link to a candidate that is gone is missing, not left out") {
  const Folder folder;
  folder.write("parts/x.stl", "x");
  folder.write("base/x.stl", "y");
  folder.write("base/lost.stl", "y");
  std::filesystem::create_symlink("gone.stl", folder / "parts/lost.stl");
  const List said = mistakes(folder.write("gates.yaml", manifest("{stem}", "parts/*.stl", "base/{name}")));
  REQUIRE(said.size() == 1);
  CHECK(holds(said, "gate 'lost': the candidate"));
}

TEST_CASE("expand: a file of exactly the glob's name is hinted at") {
  const Folder folder;
  folder.write("part[1].stl", "x");
  folder.write("base.stl", "x");
  CHECK(holds(mistakes(folder.write("gates.yaml", manifest("x", "part[1].stl", "base.stl"))),
              "write '[[]' for a '[' in it"));
  CHECK(mistakes(folder.write("gates.yaml", manifest("x", "part[[]1].stl", "base.stl"))).empty());
}

TEST_CASE("expand: names are unique in the whole manifest, even with missing files") {
  const Folder folder;
  folder.write("a/x.stl", "x");
  folder.write("b/x.stl", "x");
  folder.write("base.stl", "x");
  const std::string second = "- {name: x, candidate: gone.stl, baseline: base.stl, max_distance: 1}\n";
  const List said = mistakes(folder.write("gates.yaml", manifest("{stem}", "?/x.stl", "base.stl") + second));
  REQUIRE(said.size() == 3);
  CHECK(said[0] == "gates.yaml:3:9: the name 'x' is taken twice in this gate: write {dir} in it as well");
  CHECK(said[1] == "gates.yaml:7:10: the name 'x' is taken by the gate in line 3");
  CHECK(holds(said, "gone.stl' does not exist"));
}

TEST_CASE("expand: a name made of a file name that is not UTF-8, or has a control character, is refused") {
  const Folder folder;
  folder.write("parts/x\xFF.stl", "x");
  folder.write("parts/y\nz.stl", "x");
  folder.write("base.stl", "y");
  const List said = mistakes(folder.write("gates.yaml", manifest("{stem}", "parts/*", "base.stl")));
  REQUIRE(said.size() == 2);
  CHECK(holds(said, "is made of a file name that is not UTF-8: rename the file"));
  CHECK(holds(said, "is made of a file name that has a control character: rename the file"));
}

namespace {

const std::string kOther = "  unmatched_baselines: ignore\n";

// A folder in which the exporter did not write b.
void without_b(const Folder& folder) {
  for (const char* file : {"new/a.stl", "base/a.off", "base/b.off"}) folder.write(file, file);
}

}  // namespace

TEST_CASE("expand: a baseline whose candidate was not written is a mistake") {
  const Folder folder;
  without_b(folder);
  const std::string text = manifest("{stem}", "new/*.stl", "base/{stem}.off");
  const List said = mistakes(folder.write("gates.yaml", text));
  REQUIRE(said.size() == 1);
  CHECK(said[0].starts_with("gates.yaml:5:13: the baseline '"));
  CHECK(said[0].find("base/b.off' has no candidate: 'new/*.stl' finds none") != std::string::npos);
  CHECK(mistakes(folder.write("gates.yaml", text + kOther)).empty());
  CHECK(mistakes(folder / "gates.yaml", Baselines::may_be_missing).empty());
  const std::string defaults = "defaults: {unmatched_baselines: ignore}\n";
  CHECK(mistakes(folder.write("gates.yaml", defaults + text)).empty());
  CHECK(mistakes(folder.write("gates.yaml", defaults + text + "  unmatched_baselines: error\n")).size() == 1);
}

TEST_CASE("expand: a baseline is matched by any gate of the manifest") {
  const Folder folder;
  without_b(folder);
  folder.write("supported/b.stl", "x");
  std::filesystem::create_directory_symlink("base", folder / "link");
  const std::string text = manifest("{stem}", "new/*.stl", "base/{stem}.off");
  for (const char* baseline : {"base/b.off", "./base/../base/b.off", "link/b.off"}) {
    CAPTURE(baseline);
    const std::string other = std::string("- {name: other, candidate: supported/b.stl, max_distance: 1, baseline: ");
    CHECK(mistakes(folder.write("gates.yaml", text + other + baseline + "}\n")).empty());
  }
}

TEST_CASE("expand: only files that match the baseline's template need a candidate") {
  const Folder folder;
  for (const char* file : {"new/x-a.stl", "base/x-a.off", "base/y-b.off", "base/x-c.obj", "base/deep/x-d.off"})
    folder.write(file, file);
  CHECK(mistakes(folder.write("gates.yaml", manifest("{stem}", "new/x-*.stl", "base/{stem}.off"))).empty());
  folder.write("base/x-b.off", "x");
  CHECK(holds(mistakes(folder / "gates.yaml"), "x-b.off' has no candidate"));
}

TEST_CASE("expand: baselines in subfolders need a candidate as well") {
  const Folder folder;
  for (const char* file : {"new/a.stl", "new/near/b.stl", "base/a.stl", "base/near/b.stl"}) folder.write(file, file);
  const std::string text = manifest("{dir}/{stem}", "new/**/*.stl", "base/{dir}/{name}");
  CHECK(mistakes(folder.write("gates.yaml", text)).empty());
  folder.write("base/far/away/c.stl", "x");
  const List said = mistakes(folder / "gates.yaml");
  REQUIRE(said.size() == 1);
  CHECK(holds(said, "base/far/away/c.stl' has no candidate"));
}

TEST_CASE("expand: files of gates that are not selected may be missing") {
  const Folder folder;
  without_b(folder);
  const std::string text = manifest("part-{stem}", "new/*.stl", "base/{stem}.off") +
                           "- {name: gone, candidate: gone.stl, baseline: gone.off, max_distance: 1}\n"
                           "- {name: 'lod-{stem}', candidate: 'gone/*.stl', baseline: gone.off, max_distance: 1}\n";
  const auto file = folder.write("gates.yaml", text);
  const auto said = [&](const char* pattern) {
    return defects_of(gates_of(file, Baselines::must_exist, Selection({pattern}))).size();
  };
  CHECK(mistakes(file).size() == 4);
  CHECK(said("part-a") == 0);
  for (const char* pattern : {"part-b", "part-*"}) CHECK(said(pattern) == 0);  // unmatched baselines are for all gates
  CHECK(said("gone") == 2);
  CHECK(said("lod-?") == 1);
}
