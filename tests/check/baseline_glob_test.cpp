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
