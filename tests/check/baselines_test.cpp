#include "check/manifest/baselines.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/manifest/manifest.h"
#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;
using meshgauge::api::test::small_mesh;
namespace fs = std::filesystem;

namespace {

using List = std::vector<std::string>;

Gate gate(const std::string& name, const fs::path& candidate, const fs::path& baseline) {
  Gate gate;
  gate.name = name;
  gate.candidate = candidate;
  gate.baseline = baseline;
  gate.manifest = "gates.yaml";
  gate.line = 3;
  return gate;
}

List said(const Updates& updates) {
  List out;
  for (const Mistake& mistake : updates.mistakes) out.push_back(mistake.message);
  return out;
}

// The names of what is in a folder, and below.
List files_in(const fs::path& folder) {
  List out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    out.push_back(entry.path().lexically_relative(folder).string());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

TEST_CASE("baselines: made when they are missing, replaced when they differ, left when not") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("build/new.off", small_mesh(1));
  folder.write("build/other.off", small_mesh(2));
  folder.write("build/same.off", small_mesh(3));
  folder.write("base/other.off", small_mesh(4));
  folder.write("base/same.off", small_mesh(3));
  folder.write(
      "gates.yaml",
      "version: 1\ngates:\n- {name: '{stem}', candidate: 'build/*.off', baseline: 'base/{name}', max_distance: 1}\n");
  const auto read = gates_of("gates.yaml", Baselines::may_be_missing);
  REQUIRE(read.mistakes.empty());
  const Updates plan = plan_updates(read.gates);
  REQUIRE(plan.mistakes.empty());
  REQUIRE(plan.updates.size() == 3);
  CHECK(to_string(plan.updates[0]) == "create base/new.off from build/new.off");
  CHECK(to_string(plan.updates[1]) == "replace base/other.off from build/other.off");
  CHECK(to_string(plan.updates[2]) == "leave base/same.off, the same as build/same.off");

  const List before = files_in(folder.path());
  CHECK(before.size() == 8);  // a plan writes nothing
  CHECK(folder.read("base/other.off") == small_mesh(4));

  REQUIRE(carry_out(plan).ok());
  CHECK(folder.read("base/new.off") == small_mesh(1));
  CHECK(folder.read("base/other.off") == small_mesh(2));
  CHECK(folder.read("base/same.off") == small_mesh(3));
  CHECK(files_in(folder.path()).size() == 9);  // and no temporary file
  for (const Update& update : plan_updates(read.gates).updates) CHECK(update.kind == Update::Kind::none);
}

TEST_CASE("baselines: folders are made, rights are kept") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.off", small_mesh(1));
  folder.write("old.off", small_mesh(2));
  fs::permissions("old.off", fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  REQUIRE(carry_out(plan_updates({gate("new", "x.off", "deep/er/new.off"), gate("old", "x.off", "old.off")})).ok());
  CHECK(folder.read("deep/er/new.off") == small_mesh(1));
  CHECK(folder.read("old.off") == small_mesh(1));
  CHECK(fs::status("old.off").permissions() ==
        (fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read));
}

TEST_CASE("baselines: two gates may share one, two candidates may not") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.off", small_mesh(1));
  folder.write("y.off", small_mesh(2));
  CHECK(plan_updates({gate("there", "x.off", "b.off"), gate("back", "./x.off", "b.off")}).updates.size() == 1);
  const List mistakes = said(plan_updates({gate("x", "x.off", "b.off"), gate("y", "y.off", "b.off")}));
  REQUIRE(mistakes.size() == 1);
  CHECK(mistakes[0] == "gate 'y': the baseline 'b.off' is that of 'x.off' as well: leave one of the two gates out");
}

TEST_CASE("baselines: a candidate that is no mesh is refused") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.off", "OFF\n3 1 0\n0 0 0\n");
  folder.write("empty.off", "");
  for (const char* candidate : {"x.off", "empty.off"}) {
    const auto plan = plan_updates({gate("x", candidate, "b.off")});
    CAPTURE(candidate);
    REQUIRE(plan.mistakes.size() == 1);
    CHECK(plan.mistakes[0].line == 3);
    CHECK(plan.mistakes[0].message.find("gate 'x': the candidate '" + std::string(candidate) + "' cannot be read: ") ==
          0);
    CHECK(plan.updates.empty());
  }
  CHECK(said(plan_updates({gate("x", "gone.off", "b.off")})) ==
        List{"gate 'x': the candidate 'gone.off' does not exist"});
}

TEST_CASE("baselines: a candidate without a group of the gate is refused") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\ng lid\nf 1 2 3\n");
  const auto asks_for = [](const char* group) {
    Gate asking = gate("x", "x.obj", "b.obj");
    asking.request.options.regions.push_back({meshgauge::Group{group, {}}, {}, "top"});
    return asking;
  };
  CHECK(plan_updates({asks_for("lid")}).updates.size() == 1);
  const List refused{
      "gate 'x': the candidate 'x.obj' has no group 'Lid', which the region 'top' needs: export it with its groups, or "
      "change the region"};
  CHECK(said(plan_updates({asks_for("Lid")})) == refused);
  CHECK(said(plan_updates({gate("w", "x.obj", "b.obj"), asks_for("Lid")})) == refused);
}

TEST_CASE("baselines: candidate and baseline must have the same suffix") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.off", small_mesh());
  folder.write("y.OFF", small_mesh());
  for (const char* baseline : {"b.stl", "b", "b.off.gz", "b.gz", "b.off.x"}) {
    CAPTURE(baseline);
    const List mistakes = said(plan_updates({gate("x", "x.off", baseline)}));
    REQUIRE(mistakes.size() == 1);
    CHECK(mistakes[0].find("ends in another suffix") != std::string::npos);
  }
  CHECK(said(plan_updates({gate("y", "y.OFF", "b.off")})).empty());
}

TEST_CASE("baselines: no link is followed out of the folder, and none replaced") {
  const Folder folder;
  const Folder other;
  const Inside inside(folder.path());
  folder.write("x.off", small_mesh(1));
  folder.write("real/b.off", small_mesh(2));
  other.write("b.off", small_mesh(2));
  fs::create_symlink("real/b.off", "link.off");
  fs::create_symlink("gone.off", "lost.off");
  fs::create_directory_symlink(other.path(), "out");
  fs::create_directory_symlink("real", "in");
  fs::create_directory_symlink("out", "in_two_steps");
  const auto refusal = [](const fs::path& baseline) {
    const List mistakes = said(plan_updates({gate("x", "x.off", baseline)}));
    REQUIRE(mistakes.size() == 1);
    return mistakes[0];
  };
  CHECK(refusal("link.off") ==
        "gate 'x': the baseline 'link.off' is a symbolic link to 'real/b.off': name the file itself, or "
        "remove the link");
  CHECK(refusal("lost.off").find("is a symbolic link to 'gone.off'") != std::string::npos);
  CHECK(refusal("out/b.off").find("lies behind the symbolic link") != std::string::npos);
  CHECK(refusal("out/new/b.off").find("lies behind the symbolic link") != std::string::npos);
  CHECK(refusal("in_two_steps/b.off").find("lies behind the symbolic link") != std::string::npos);
  CHECK(refusal(folder / "out/b.off").find("lies behind the symbolic link") != std::string::npos);

  REQUIRE(carry_out(plan_updates({gate("in", "x.off", "in/b.off"), gate("named", "x.off", other / "named.off")})).ok());
  CHECK(folder.read("real/b.off") == small_mesh(1));
  CHECK(fs::is_symlink("in"));
  CHECK(other.read("named.off") == small_mesh(1));  // another folder, by its name
  CHECK(other.read("b.off") == small_mesh(2));
}

TEST_CASE("baselines: a failed write leaves all files as they were") {
  const Folder folder;
  const Inside inside(folder.path());
  folder.write("x.off", small_mesh(1));
  folder.write("base/b.off", small_mesh(2));
  folder.write("file", "");
  Updates plan = plan_updates({gate("b", "x.off", "base/b.off")});
  plan.updates.push_back({"c", "x.off", "file/c.off", Update::Kind::create});  // a file has come to be in the way since
  const auto done = carry_out(plan);
  REQUIRE(!done.ok());
  CHECK(done.error().message.find("'file' could not be made: ") == 0);
  CHECK(folder.read("base/b.off") == small_mesh(2));
  CHECK(files_in(folder.path()) == List{"base", "base/b.off", "file", "x.off"});
}

TEST_CASE("baselines: a glTF of several files is refused") {
  const Folder folder;
  const Inside inside(folder.path());
  const std::string scene = R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "x.bin"}]})";
  folder.write("build/s.gltf", scene);
  folder.write("base/s.gltf", scene);
  const auto updates = plan_updates({gate("s", "build/s.gltf", "base/s.gltf")});
  CHECK(said(updates) == List{"gate 's': the candidate 'build/s.gltf' names 'x.bin' beside it, which would not be "
                              "copied: export it as one .glb"});
}
