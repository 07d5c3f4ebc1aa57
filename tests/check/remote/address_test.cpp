#include "check/remote/address.h"

#include <doctest/doctest.h>

using namespace meshgauge::check::service;

TEST_CASE("address: the base of URLs") {
  const std::pair<const char*, const char*> cases[] = {
      {"http://localhost:8080", "http://localhost:8080"},
      {"http://localhost:8080/", "http://localhost:8080"},
      {"https://ci.example/meshgauge/", "https://ci.example/meshgauge"},
      {"https://ci.example/a/b//", "https://ci.example/a/b"},
      {"http://[::1]:8080", "http://[::1]:8080"},
      {"https://ci.example:443", "https://ci.example:443"},
  };
  for (const auto& [url, base] : cases) {
    CAPTURE(url);
    const auto found = base_of(url);
    REQUIRE(found.ok());
    CHECK(*found == base);
  }
}

TEST_CASE("address: malformed addresses are refused") {
  for (const char* url : {"", "localhost:8080", "ftp://localhost/", "file:///etc/passwd", "http://", "http://a b/",
                          "http://localhost:99999", "https://ci.example/?key=1", "https://ci.example/#top",
                          "httpx://localhost", "//localhost"}) {
    CAPTURE(url);
    CHECK_FALSE(base_of(url).ok());
  }
}

TEST_CASE("address: a password in it is refused and not repeated") {
  const auto found = base_of("https://ci:sesame@ci.example");
  REQUIRE_FALSE(found.ok());
  CHECK(found.error().message.find("sesame") == std::string::npos);
  CHECK(found.error().message.find("--key-file") != std::string::npos);
}

TEST_CASE("address: https and loopback addresses are private") {
  for (const char* url : {"https://ci.example", "http://localhost:8080", "http://LOCALHOST", "http://127.0.0.1:8080/a",
                          "http://127.8.0.1", "http://[::1]:8080"}) {
    CAPTURE(url);
    CHECK(is_private(*base_of(url)));
  }
  for (const char* url : {"http://ci.example", "http://127.0.0.1.ci.example", "http://localhost.ci.example",
                          "http://10.0.0.1", "http://[::2]", "http://ci.example/https://localhost"}) {
    CAPTURE(url);
    CHECK_FALSE(is_private(*base_of(url)));
  }
}

TEST_CASE("address: a link keeps the address and is safe in reports") {
  CHECK(link_to("https://ci.example:8443/a-b_c", "/c/0d67") == "https://ci.example:8443/a-b_c/c/0d67");
  CHECK(link_to("http://[::1]:8080", "/c/0d67") == "http://[::1]:8080/c/0d67");
  CHECK(link_to("http://x/a%20b", "/c/1") == "http://x/a%20b/c/1");
  CHECK(link_to("http://x/<\"'&>)(\\|`", "/c/1") == "http://x/%3C%22%27%26%3E%29%28%5C%7C%60/c/1");
  CHECK(link_to("http://x/\n\xc3\xa9", "/c/1") == "http://x/%0A%C3%A9/c/1");
}

TEST_CASE("address: keys are visible and not empty") {
  CHECK(is_key("mg_0123"));
  for (const char* key : {"", "two words", "two\nlines", "caf\xc3\xa9", "tab\t"}) CHECK_FALSE(is_key(key));
}

TEST_CASE("address: a file's name is made safe for a header") {
  CHECK(disposition("parts/bracket one.stl") == "attachment; filename=\"bracket one.stl\"");
  CHECK(disposition("a\"b\\c\r\nX: y.obj") == "attachment; filename=\"a_b_c__X: y.obj\"");
  const std::string name = disposition(std::string(300, 'x') + ".glb");
  CHECK(name.size() < 255);
  CHECK(name.ends_with("x.glb\""));
}

TEST_CASE("address: foreign text is one line") {
  CHECK(one_line("a\nb\x1b[31mc\x7f") == "a b [31mc ");
  CHECK(one_line("abcdef", 3) == "abc...");
}
