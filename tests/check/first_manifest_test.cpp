#include "check/manifest/first_manifest.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/manifest/baselines.h"
#include "check/manifest/manifest.h"
#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;
using meshgauge::api::test::small_mesh;

namespace {

using List = std::vector<std::string>;

// What the manifest of the folder says of its gates, "NAME: CANDIDATE, BASELINE", or its mistakes.
List first(const Folder& folder, Baselines baselines = Baselines::must_exist) {
  const Inside inside(folder.path());
  const auto manifest = first_manifest(".", "0.1 %");
  if (!manifest) return {manifest.error().message};
  folder.write("gates.yaml", manifest->text);
  List out;
  const auto read = gates_of("gates.yaml", baselines);
  for (const Mistake& mistake : read.mistakes) out.push_back(mistake.message);
  for (const Gate& gate : read.gates)
    out.push_back(gate.name + ": " + gate.candidate.string() + ", " + gate.baseline.string());
  return out;
}

void fill(const Folder& folder, const List& files) {
  for (const std::string& file : files) folder.write(file, small_mesh());
}

}  // namespace

TEST_CASE("first manifest: two folders of the same names are candidates and baselines") {
  const Folder folder;
  fill(folder, {"parts/a.off", "parts/B.OFF", "baselines/a.off", "baselines/B.OFF", "readme.txt", "parts/.c.off"});
  CHECK(first(folder) == List{"B: parts/B.OFF, baselines/B.OFF", "a: parts/a.off, baselines/a.off"});
  CHECK(folder.read("gates.yaml").find("candidate: \"parts/*.[oO][fF][fF]\"") != std::string::npos);
  CHECK(folder.read("gates.yaml").find("# Look at this limit") != std::string::npos);
}

TEST_CASE("first manifest: baselines of another format") {
  const Folder folder;
  fill(folder, {"new/a.stl", "new/b.stl", "golden/a.off", "golden/b.off"});
  CHECK(first(folder) == List{"a: new/a.stl, golden/a.off", "b: new/b.stl, golden/b.off"});
}

TEST_CASE("first manifest: where no name says which is which, a comment asks") {
  const Folder folder;
  fill(folder, {"one/a.off", "two/a.off"});
  CHECK(first(folder) == List{"a: one/a.off, two/a.off"});
  CHECK(folder.read("gates.yaml").find("# Look at this: is \"two\" the folder of the wanted meshes?") !=
        std::string::npos);
}

TEST_CASE("first manifest: other meshes get baselines that are to be made") {
  const Folder folder;
  fill(folder, {"a.off", "B.OFF", "x.off.gz"});
  CHECK(first(folder, Baselines::may_be_missing) ==
        List{"B: B.OFF, baselines/B.OFF", "a: a.off, baselines/a.off", "x: x.off.gz, baselines/x.off.gz"});
  const Inside inside(folder.path());
  CHECK(plan_updates(gates_of("gates.yaml", Baselines::may_be_missing).gates).updates.size() == 3);
}

TEST_CASE("first manifest: names stay unique over folders and formats") {
  const Folder folder;
  fill(folder, {"near/x.off", "near/x.obj", "far/z.off", "y.off"});
  const List gates = first(folder, Baselines::may_be_missing);
  CHECK(gates.size() == 4);
  for (const std::string& gate : gates) CHECK(gate.find(", baselines/") != std::string::npos);
}

TEST_CASE("first manifest: names that mean something to globs, templates and YAML") {
  const Folder folder;
  fill(folder, {"pa[r]ts \"x\"\\/{a}.off", "pa[r]ts \"x\"\\/[b].off", "base/{a}.off", "base/[b].off"});
  CHECK(first(folder) ==
        List{"[b]: pa[r]ts \"x\"\\/[b].off, base/[b].off", "{a}: pa[r]ts \"x\"\\/{a}.off, base/{a}.off"});
}

TEST_CASE("first manifest: refused without meshes") {
  const Folder folder;
  folder.write("notes.txt", "x");
  CHECK(first(folder) ==
        List{"no mesh file is in '.' or in the folders directly in it: name the folder that holds them"});
}

TEST_CASE("first manifest: an example of a gate") {
  CHECK(
      example_gate({"parts/a.stl", "parts/B.STL"}, "baselines") ==
      "{name: \"{stem}\", candidate: \"parts/*.[sS][tT][lL]\", baseline: \"baselines/{name}\", max_distance: 0.05 mm}");
  CHECK(example_gate({"a.stl", "parts/b.stl"}, "baselines") ==
        "{name: \"a\", candidate: \"a.stl\", baseline: \"baselines/a.stl\", max_distance: 0.05 mm}");
}
