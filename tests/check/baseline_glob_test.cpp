#include "check/baseline_glob.h"

#include <doctest/doctest.h>

using namespace meshgauge::check;

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
                         {"/new/*.stl", "/base[1]/{stem}.off", "/base[[]1]/*.off"}}) {
    CAPTURE(row.candidate);
    CHECK(baseline_glob(row.candidate, row.baseline) == row.glob);
  }
}

TEST_CASE("baseline glob: what a baseline tells of its candidate") {
  const auto parts = [](const char* path, const char* baseline) {
    const NameParts seen = parts_of_baseline(path, baseline);
    return seen.stem + " " + seen.name + " " + seen.dir;
  };
  CHECK(parts("base/ref-a.off", "base/ref-{stem}.off") == "a * *");
  CHECK(parts("base/near/a.stl.gz", "base/{dir}/{name}") == "a a.stl.gz *");
  CHECK(parts("base/near.off", "base/{dir}.off") == "* * *");
  CHECK(parts("base/a-a.off", "base/{stem}-{stem}.off") == "* * *");
  CHECK(parts("base/a/x.off", "base/{stem}/x.off") == "* * *");
}
