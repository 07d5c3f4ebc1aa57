#include "server/base/address_tag.h"

#include <doctest/doctest.h>

using namespace meshgauge::server;

TEST_CASE("address tag: one for each address, which it does not show") {
  const std::string tag = address_tag("192.0.2.1");
  CHECK(tag == address_tag("192.0.2.1"));
  CHECK(tag != address_tag("192.0.2.2"));
  CHECK(tag.size() == 32);
  CHECK(tag.find_first_not_of("0123456789abcdef") == std::string::npos);
}
