// 3MF packages that the tests read.
#pragma once

#include <string>
#include <utility>

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {

// Places the object 1.
inline const std::string kItem = "<item objectid=\"1\"/>";

// Reads a 3MF; the test fails unless it is accepted.
inline ReadMesh good_3mf(const std::string& file) {
  auto result = read(file, "m.3mf");
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  CHECK(result->format == Format::three_mf);
  return std::move(*result);
}

}  // namespace meshgauge::api::test
