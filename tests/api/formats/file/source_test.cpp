#include "api/formats/file/source.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

using namespace std::string_literals;

TEST_CASE("source: the length of text without NUL and 0x1A bytes at its end") {
  CHECK(length_without_padding("") == 0);
  CHECK(length_without_padding("v 1\n") == 4);
  CHECK(length_without_padding("v 1\n \n") == 6);
  CHECK(length_without_padding("v 1\n\0"s) == 4);
  CHECK(length_without_padding("v 1\n\x1A") == 4);
  CHECK(length_without_padding("v 1\n\x1A\r\n\0 \0\0\n"s) == 4);
  CHECK(length_without_padding("v 1\x1A") == 3);
  CHECK(length_without_padding("\0\0\x1A"s) == 0);
  CHECK(length_without_padding("v\0 1\n"s) == 5);
  CHECK(length_without_padding("v 1\n" + std::string(kMostPadding, '\0')) == 4);
  CHECK(length_without_padding("v 1\n" + std::string(kMostPadding + 1, '\0')) == 4 + kMostPadding + 1);
}

TEST_CASE("source: a reader sees the bytes without padding, and a remark says that there was some") {
  const ReadLimits limits;
  std::string_view seen;
  const auto reader = [&](const Source& source) -> Result<ReadMesh> {
    seen = source.text();
    ReadMesh out;
    out.notes.remarks.emplace_back("its own");
    return out;
  };
  const std::string padded = "v 1\n\0\0\x1A"s;
  const auto read = read_without_padding(Source{bytes_of(padded), "a", limits}, reader);
  REQUIRE(read.ok());
  CHECK(seen == "v 1\n");
  CHECK(read->notes.remarks == std::vector<std::string>{"its own", "NUL or 0x1A bytes after the last line, ignored"});
  CHECK(read_without_padding(Source{bytes_of("v 1\n"), "a", limits}, reader)->notes.remarks.size() == 1);
}

}  // namespace
}  // namespace meshgauge::api::test
