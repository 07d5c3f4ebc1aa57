#include "api/base/digest.h"

#include <new>

#include <doctest/doctest.h>
#include <openssl/evp.h>

using namespace meshgauge;

namespace {

constexpr const char* kOfNothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

int waits = 0;

// As where memory is missing, OpenSSL finds no SHA-256 until it is given back here.
void give_back() {
  if (++waits == 2) EVP_set_default_properties(nullptr, "");
}

}  // namespace

TEST_CASE("digest: what fails in OpenSSL waits, as operator new does") {
  REQUIRE(EVP_set_default_properties(nullptr, "provider=none") == 1);
  const std::new_handler before = std::set_new_handler(nullptr);
  CHECK_THROWS_AS((void)api::sha256_hex({}), std::bad_alloc);
  std::set_new_handler(give_back);
  CHECK(api::sha256_hex({}) == kOfNothing);
  CHECK(waits == 2);
  std::set_new_handler(before);
}
