#include "check/manifest/passed_over.h"

#include <chrono>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/manifest/manifest.h"
#include "folder.h"

using namespace meshgauge::check;
using meshgauge::api::test::Folder;
using meshgauge::api::test::Inside;

namespace {

using List = std::vector<std::string>;

std::string gates(const std::string& candidate, const std::string& baseline, const std::string& more = "") {
  return "version: 1\ndefaults: {max_distance: 1" + more + "}\ngates:\n- {name: '{name}', candidate: '" + candidate +
         "', baseline: '" + baseline + "'}\n";
}

List mistakes(const Folder& folder, const std::string& text, const Selection& only = {}) {
  folder.write("gates.yaml", text);
  const Inside inside(folder.path());
  List said;
  for (const Mistake& mistake : defects_of(gates_of("gates.yaml", Baselines::must_exist, only)))
    said.push_back(mistake.message);
  return said;
}

const std::string kIgnore = ", unmatched_baselines: ignore";

}  // namespace

TEST_CASE("passed over: files that a glob misses only by case are a mistake") {
  const Folder folder;
  for (const char* file : {"parts/a.stl", "parts/BRACKET.STL", "Parts/b.stl", "base/x.stl", "parts/sub.stl/x"})
    folder.write(file, file);
  CHECK(mistakes(folder, gates("parts/*.stl", "base/x.stl")) ==
        List{"gate '{name}': the candidate 'parts/*.stl' passes over 'Parts/b.stl' and 'parts/BRACKET.STL', which it "
             "misses only by upper and lower case: write '[pP]arts/*.[sS][tT][lL]' to take both, or rename them"});
  CHECK(mistakes(folder, gates("[pP]arts/*.[sS][tT][lL]", "base/x.stl")).empty());
  CHECK(mistakes(folder, gates("parts/*.obj", "base/x.stl")) ==
        List{"gate '{name}': the candidate 'parts/*.obj' finds no file; paths are relative to the manifest's folder"});
}

TEST_CASE("passed over: a glob that finds nothing says what it misses") {
  const Folder folder;
  for (const char* file : {"parts/BRACKET.STL", "base/x.stl", "hidden/.x.stl"}) folder.write(file, file);
  CHECK(mistakes(folder, gates("PARTS/*.stl", "base/x.stl")) ==
        List{"gate '{name}': the candidate 'PARTS/*.stl' finds no file; it passes over 'parts/BRACKET.STL', which it "
             "misses only by upper and lower case: write '[pP][aA][rR][tT][sS]/*.[sS][tT][lL]' to take both, or rename "
             "it"});
  CHECK(mistakes(folder, gates("parts\\*.STL", "base/x.stl")) ==
        List{"gate '{name}': the candidate 'parts\\*.STL' finds no file; it passes over 'parts/BRACKET.STL': folders "
             "are separated by '/', not by '\\'; write 'parts/*.STL'"});
  CHECK(
      mistakes(folder, gates("gone\\*.STL", "base/x.stl")) ==
      List{"gate '{name}': the candidate 'gone\\*.STL' finds no file; paths are relative to the manifest's folder, and "
           "folders are separated by '/'"});
  CHECK(mistakes(folder, gates("hidden/*.stl", "base/x.stl")) ==
        List{"gate '{name}': the candidate 'hidden/*.stl' finds no file; 'hidden/*.stl' passes over 'hidden/.x.stl': a "
             "wildcard matches no leading dot, so it is not measured"});
}

TEST_CASE("passed over: blanks and backslashes") {
  const Folder folder;
  for (const char* file : {"parts/a.stl", "parts/b.stl ", "parts /c.stl", "parts\\d.stl", "base/x.stl"})
    folder.write(file, file);
  CHECK(
      mistakes(folder, gates("parts/*.stl", "base/x.stl")) ==
      List{"gate '{name}': the candidate 'parts/*.stl' passes over 'parts /c.stl' and 'parts/b.stl ', which it misses "
           "only by blanks at the ends of names: rename them",
           "gate '{name}': the candidate 'parts/*.stl' passes over 'parts\\d.stl': folders are separated by '/', not "
           "by '\\'; move it into the folder"});
  CHECK(mistakes(folder, gates("**/a.stl", "base/x.stl")).empty());
  CHECK(mistakes(folder, gates("**/d.stl", "base/x.stl")).size() == 1);
}

TEST_CASE("passed over: what another gate takes, or is not selected, is not") {
  const Folder folder;
  for (const char* file : {"parts/a.stl", "parts/B.STL", "base/x.stl"}) folder.write(file, file);
  const std::string text = gates("parts/*.stl", "base/x.stl");
  const std::string other = "- {name: other, candidate: parts/B.STL, baseline: base/x.stl}\n";
  CHECK(mistakes(folder, text + other).empty());
  CHECK(mistakes(folder, text, Selection({"a.stl"})).empty());
  CHECK(mistakes(folder, text, Selection({"B*"})).size() == 1);
  CHECK(mistakes(folder, text).size() == 1);
  std::filesystem::remove(folder / "parts/B.STL");
  std::filesystem::create_symlink("a.stl", folder / "parts/A.STL");  // as where case does not count
  CHECK(mistakes(folder, text).empty());
}

TEST_CASE("passed over: pairs that exist in other case are named") {
  const Folder folder;
  for (const char* file : {"parts/BRACKET.stl", "base/bracket.stl", "parts/x.stl", "base/x.stl"})
    folder.write(file, file);
  CHECK(
      mistakes(folder, gates("parts/*.stl", "base/{stem}.stl")) ==
      List{
          "the baseline 'base/bracket.stl', which differs only by case or blanks from 'base/BRACKET.stl', the baseline "
          "of a gate, has no candidate: 'parts/*.stl' finds none; when there is to be none, remove the baseline, or "
          "write 'unmatched_baselines: ignore'",
          "gate 'BRACKET.stl': the baseline 'base/BRACKET.stl' does not exist; there is 'base/bracket.stl': upper and "
          "lower case count"});
  CHECK(
      mistakes(folder, gates("parts/bracket.stl", "base/x.stl")) ==
      List{"gate 'bracket.stl': the candidate 'parts/bracket.stl' does not exist; there is 'parts/BRACKET.stl': upper "
           "and lower case count"});
  CHECK(mistakes(folder, gates("parts\\x.stl", "base\\x.stl")) ==
        List{"gate 'parts\\x.stl': the candidate 'parts\\x.stl' does not exist; folders are separated by '/': there is "
             "'parts/x.stl'",
             "gate 'parts\\x.stl': the baseline 'base\\x.stl' does not exist; folders are separated by '/': there is "
             "'base/x.stl'"});
}

TEST_CASE("passed over: a baseline whose suffix has another case needs a candidate") {
  const Folder folder;
  for (const char* file : {"parts/x.stl", "base/x.stl", "base/LOST.STL"}) folder.write(file, file);
  const List said = mistakes(folder, gates("parts/*.stl", "base/{stem}.stl"));
  REQUIRE(said.size() == 1);
  CHECK(said[0].starts_with("the baseline 'base/LOST.STL' has no candidate: 'parts/*.stl' finds none"));
  CHECK(mistakes(folder, gates("parts/*.stl", "base/{stem}.stl", kIgnore)).empty());
}

TEST_CASE("passed over: meshes that begin with a dot are a note of the gate") {
  const Folder folder;
  for (const char* file :
       {"parts/a.stl", "parts/.b.stl", "parts/._a.stl", "parts/.git/c.stl", "parts/.txt", "base/x.stl"})
    folder.write(file, file);
  folder.write("gates.yaml", gates("parts/**/*", "base/x.stl"));
  const Inside inside(folder.path());
  const auto read = gates_of("gates.yaml");
  REQUIRE(read.mistakes.empty());
  REQUIRE(read.gates.size() == 1);
  CHECK(read.gates[0].notes ==
        List{"'parts/**/*' passes over 'parts/._a.stl', 'parts/.b.stl' and 'parts/.git/c.stl': a wildcard matches no "
             "leading dot, so they are not measured"});
}

TEST_CASE("passed over: time is linear, and messages are short") {
  const Folder folder;
  std::filesystem::create_directory(folder / "parts");
  for (int i = 0; i < 5000; ++i) folder.write("parts/P" + std::to_string(i) + ".STL", "");
  folder.write("parts/a.stl", "x");
  folder.write("base/x.stl", "x");
  const List said = mistakes(folder, gates("parts/*.stl", "base/x.stl"));
  REQUIRE(said.size() == 1);
  CHECK(said[0].size() < 5000);
  CHECK(said[0].find(" and 4968 more, which it misses") != std::string::npos);
}
