// The manifests of tests/check/manifests. At the top of each stands, in comments, what it has to give: in good/ its
// gates ("NAME: CANDIDATE, BASELINE"), in wrong/ its mistakes ("LINE:COLUMN: words"); and a line for schema_test.py.
// Then patterns alone: of the baselines of a glob, and of --only.
#include "check/manifest/manifest.h"

#include <fstream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "check/manifest/manifest_text.h"
#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Inside;

namespace {

namespace fs = std::filesystem;
const fs::path kManifests = fs::path(MESHGAUGE_SOURCE_DIR) / "tests/check/manifests";

// The comments at the top, a line each, without their '# ', and without the line about the schema.
std::string expected(const fs::path& manifest) {
  std::ifstream file(manifest);
  std::string lines;
  for (std::string line; std::getline(file, line) && line.starts_with("# ");) {
    if (!line.starts_with("# schema: ")) lines += line.substr(2) + "\n";
  }
  return lines;
}

std::vector<fs::path> manifests_in(const char* folder) {
  std::set<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(kManifests / folder))
    paths.insert(fs::path(folder) / entry.path().filename());
  return {paths.begin(), paths.end()};
}

std::set<std::string> keys_of(const nlohmann::json& object) {
  std::set<std::string> keys;
  for (const auto& [key, value] : object.at("properties").items()) keys.insert(key);
  return keys;
}

// What a message lists as known when nothing is near: "unknown key '%'; known: a, b".
std::set<std::string> known_keys(const std::string& manifest) {
  Mistakes mistakes;
  read_manifest(manifest, mistakes);
  std::set<std::string> keys;
  for (const Mistake& mistake : std::move(mistakes).sorted()) {
    const std::size_t list = mistake.message.find("; known: ");
    if (list == std::string::npos) continue;
    std::string_view rest = std::string_view(mistake.message).substr(list + 9);
    while (!rest.empty()) {
      const std::size_t comma = rest.find(", ");
      keys.emplace(rest.substr(0, comma));
      rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 2);
    }
  }
  return keys;
}

}  // namespace

TEST_CASE("manifest: each mistake has its line, column and remedy") {
  const Inside inside(kManifests);
  const auto manifests = manifests_in("wrong");
  CHECK(manifests.size() >= 80);
  for (const fs::path& manifest : manifests) {
    CAPTURE(manifest);
    std::string said;
    for (const Mistake& mistake : defects_of(gates_of(manifest))) {
      said += to_string(manifest.string(), mistake).substr(manifest.string().size() + 1) + "\n";
    }
    CHECK(said == expected(manifest));
    CHECK(!said.empty());
  }
}

TEST_CASE("manifest: good ones give their gates") {
  const Inside inside(kManifests);
  for (const fs::path& manifest : manifests_in("good")) {
    CAPTURE(manifest);
    const Gates read = gates_of(manifest);
    for (const Mistake& mistake : read.mistakes) FAIL_CHECK(to_string(manifest.string(), mistake));
    std::string given;
    for (const Gate& gate : read.gates) {
      given += gate.name + ": " + gate.candidate.string() + ", " + gate.baseline.string() + "\n";
      CHECK(gate.manifest == manifest);
      CHECK(gate.line > 0);
    }
    CHECK(given == expected(manifest));
  }
}

TEST_CASE("manifest: the schema has the keys that are read, and no others") {
  std::ifstream file(fs::path(MESHGAUGE_SOURCE_DIR) / "check/gates.schema.json");
  const auto schema = nlohmann::json::parse(file);
  CHECK(known_keys("version: 1\n'%': 1\ngates: []\n") == keys_of(schema));
  std::set<std::string> settings = keys_of(schema.at("$defs").at("settings"));
  CHECK(known_keys("version: 1\ngates: [{'%': 1}]\n") == settings);
  for (const char* of_gate_alone : {"name", "candidate", "baseline"}) CHECK(settings.erase(of_gate_alone) == 1);
  CHECK(known_keys("version: 1\ndefaults: {'%': 1}\ngates: []\n") == settings);
  CHECK(known_keys("version: 1\ndefaults: {tolerance: {'%': 1}}\ngates: []\n") ==
        keys_of(schema.at("$defs").at("tolerance")));
}

TEST_CASE("manifest: an unreadable file is one mistake without a line") {
  const meshgauge::api::test::Folder folder;
  const auto first = [](const fs::path& manifest) {
    const auto read = gates_of(manifest);
    REQUIRE(read.mistakes.size() == 1);
    CHECK(read.mistakes[0].line == 0);
    return read.mistakes[0].message;
  };
  CHECK(first(folder / "gone.yaml") == "cannot be read: No such file or directory");
  CHECK(first(folder.path()) == "is a folder: name the manifest in it");
  CHECK(first(folder.write("large.yaml", std::string(3 << 20, '#'))) == "larger than 1048576 bytes");
  if (fs::exists("/dev/zero")) CHECK(first("/dev/zero") == "larger than 1048576 bytes");
}

TEST_CASE("baseline glob: the names that candidates of a glob can give") {
  struct Row {
    const char* candidate;
    const char* baseline;
    const char* glob;
  };
  for (const Row& row : {Row{"new/*.stl", "base/{stem}.off", "base/*.off"},
                         {"new/x-*.stl", "base/{stem}.off", "base/x-*.off"},
                         {"new/*.stl.gz", "base/{stem}.off", "base/*.off"},
                         {"new/x*.gz", "base/{stem}.off", "base/x*.off"},
                         {"new/part.*", "base/{stem}.off", "base/part*.off"},
                         {"new/p*.s?l", "base/{stem}.off", "base/p*.off"},
                         {"new/*stl", "base/{stem}.off", "base/*.off"},
                         {"new/x[.]stl", "base/{stem}.off", "base/x*.off"},
                         {"new/x.v1-*.stl", "base/{stem}.off", "base/x.v1-*.off"},
                         {"new/x-*.stl", "base/{name}", "base/x-*.stl"},
                         {"new/**/*.stl", "base/{dir}/{name}", "base/**/*.stl"},
                         {"new/**", "base/{dir}/{name}", "base/**/*"},
                         {"new/v?/in/part.stl", "base/{dir}/{stem}.off", "base/v?/in/part.off"},
                         {"new/*.stl", "base/{dir}/{stem}.off", "base/*.off"},
                         {"new/v*/*.stl", "base/{dir}{stem}.off", "base/v*.off"},
                         {"new/v*/w/*.stl", "base/x-{dir}/{stem}.off", "base/x-v*/w/*.off"},
                         {"/new/*.stl", "/base[1]/{stem}.off", "/base[[]1]/*.off"}}) {
    CAPTURE(row.candidate);
    CHECK(baseline_globs(row.candidate, row.baseline) == std::vector<std::string>{row.glob});
  }
  using Globs = std::vector<std::string>;
  CHECK(baseline_globs("new/**/mesh.stl", "base/m-{dir}.off") == Globs{"base/m-*.off", "base/m-*/**/*.off"});
  CHECK(baseline_globs("new/**/in/*.stl", "base/x-{dir}/{name}") == Globs{"base/x-*/*.stl", "base/x-*/**/*/*.stl"});
}

TEST_CASE("selection: names by any of its patterns") {
  CHECK(Selection().holds("anything"));
  const Selection some({"lod-*", "p?n", "[ab]\\c"});
  for (const char* name : {"lod-1", "lod-", "pin", "p\xC3\xA4n", "lod-near/x", "a\\c"}) CHECK(some.holds(name));
  for (const char* name : {"xlod-1", "pn", "piin", "ac", "c\\c", ""}) CHECK(!some.holds(name));
}

TEST_CASE("selection: names that are known in part") {
  const auto may = [](const char* pattern, const char* names) { return Selection({pattern}).may_hold(names); };
  CHECK(Selection().may_hold("*"));
  for (const char* names : {"*", "lod-*", "lod-a", "*-a", "l*d*a", "**"}) CHECK(may("lod-?", names));
  for (const char* names : {"part-*", "lo", "*b-", "lod", "lod*_"}) CHECK(!may("lod-a", names));
  CHECK(!may("lod-a*", "lod-b*"));
  CHECK(!may("*-a", "lod-*-b"));
  CHECK(may("*x", "x*"));
  CHECK(may("a*c", "*b*"));
  CHECK(!may("a*c", "b*"));
}
