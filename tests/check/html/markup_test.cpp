#include "check/html/markup.h"

#include <doctest/doctest.h>

using namespace meshgauge::check;

TEST_CASE("characters with a meaning in HTML become references") {
  CHECK(escaped("<a href=\"x\" onclick='y'>&amp;</a>") ==
        "&lt;a href=&quot;x&quot; onclick=&#39;y&#39;&gt;&amp;amp;&lt;/a&gt;");
  CHECK(escaped("plain, Gr\xC3\xBC\xC3\x9F"
                "e \xF0\x9F\x94\xA9\n\ttabs") ==
        "plain, Gr\xC3\xBC\xC3\x9F"
        "e \xF0\x9F\x94\xA9\n\ttabs");
}

TEST_CASE("characters that HTML forbids or that change the direction of writing become U+FFFD") {
  const std::string replaced = "a\xEF\xBF\xBDz";
  for (const std::string& bad : {std::string(1, '\0'), std::string("\x01"), std::string("\x1B"), std::string("\x7F"),
                                 std::string("\xC2\x85"), std::string("\xEF\xBF\xBE"), std::string("\xE2\x80\xAE"),
                                 std::string("\xE2\x81\xA6"), std::string("\xD8\x9C")}) {
    CAPTURE(bad);
    CHECK(escaped("a" + bad + "z") == replaced);
  }
}

TEST_CASE("bytes that are not UTF-8 are replaced, one by one, and the rest is kept") {
  const std::string mark = "\xEF\xBF\xBD";
  CHECK(escaped("a\xFFz") == "a" + mark + "z");
  CHECK(escaped("a\xC3") == "a" + mark);                            // cut short
  CHECK(escaped("\xC0\xBC") == mark + mark);                        // '<' in an overlong form
  CHECK(escaped("\xED\xA0\x80") == mark + mark + mark);             // a surrogate
  CHECK(escaped("\xF5\x80\x80\x80") == mark + mark + mark + mark);  // beyond U+10FFFF
  CHECK(escaped("\xE2\x80<") == mark + mark + "&lt;");              // the reference is not swallowed
}

TEST_CASE("base64 and digests are those of the standards") {
  const auto encoded = [](std::string_view text) { return base64(std::as_bytes(std::span(text))); };
  CHECK(encoded("") == "");
  CHECK(encoded("f") == "Zg==");
  CHECK(encoded("foobar") == "Zm9vYmFy");  // RFC 4648, section 10
  CHECK(sha256_base64("") == "47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=");
}
