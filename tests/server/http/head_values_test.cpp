#include "server/http/head_values.h"

#include <string_view>
#include <utility>

#include <doctest/doctest.h>

using meshgauge::server::weight_of;

TEST_CASE("negotiate: codings") {
  const std::pair<std::string_view, double> cases[] = {
      {"", 0},
      {"gzip", 1},
      {"br, GZIP", 1},
      {"deflate, gzip;q=1.0, *;q=0.5", 1},
      {"*", 1},
      {"*;q=0", 0},
      {"gzip;q=0", 0},
      {"*, gzip;q=0", 0},
      {"gzip;q=0, *", 0},
      {"gzip ; q=0.25", 0.25},
      {"identity", 0},
      {"gzipped, x-gzip", 0},
      {"gzip;q=2", 0},
      {"gzip;q=-1", 0},
      {"gzip;q=x", 0},
      {"gzip;q=", 0},
      {"gzip;q=nan", 0},
      {"gzip;q=1e0", 0},
      {",,;;, gzip", 1},
      {"gzip;level=9;q=0.5", 0.5},
  };
  for (const auto& [field, weight] : cases) {
    CAPTURE(field);
    CHECK(weight_of(field, "gzip") == weight);
  }
}

TEST_CASE("negotiate: the most specific type decides") {
  const char* const browser = "text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,*/*;q=0.8";
  CHECK(weight_of(browser, "text/html") == 1);
  CHECK(weight_of(browser, "text/plain") == 0.8);
  CHECK(weight_of("*/*", "text/html") == weight_of("*/*", "text/plain"));
  CHECK(weight_of("text/*;q=0.3, text/html;q=0.7, */*;q=0.5", "text/plain") == 0.3);
  CHECK(weight_of("text/*;q=0.3, text/html;q=0.7, */*;q=0.5", "text/html") == 0.7);
  CHECK(weight_of("text/*;q=0.3, text/html;q=0.7, */*;q=0.5", "image/png") == 0.5);
  CHECK(weight_of("text/html, text/html;q=0.1", "text/html") == 1);
  CHECK(weight_of("application/json", "text/html") == 0);
  CHECK(weight_of("/*", "text/html") == 0);
}
