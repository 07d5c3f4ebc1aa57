#include "api/formats/file/gzip.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

const std::string kTriangleObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string repeated(char c, std::size_t count) {
  std::string out;
  out.resize(count, c);
  return out;
}

Result<Expanded> expand(std::string_view content, const ReadLimits& limits = {}) {
  return expand_gzip(bytes_of(content), "a", limits, [](std::span<const std::byte>) { return std::nullopt; });
}

}  // namespace

TEST_CASE("gzip: a compressed file of any name is read and noted") {
  for (const char* name : {"m.obj.gz", "m.obj", "", "m.gz"}) {
    auto result = read(gzipped(kTriangleObj), name);
    REQUIRE(result.ok());
    CHECK(result->notes.gzip);
    CHECK(result->format == Format::obj);
  }
  CHECK(!read(kTriangleObj, "m.obj")->notes.gzip);
}

TEST_CASE("gzip: several members are one file, larger than any buffer") {
  std::string text = kTriangleObj;
  while (text.size() < 1'000'000) text += "v 0.125 0.25 " + std::to_string(text.size()) + "\n";
  const auto expanded = expand(gzipped(text.substr(0, 500'001)) + gzipped("") + gzipped(text.substr(500'001)));
  REQUIRE(expanded.ok());
  CHECK(std::string_view(reinterpret_cast<const char*>(expanded->data.get()), expanded->size) == text);
}

TEST_CASE("gzip: truncated and damaged files are refused at every place") {
  const std::string whole = gzipped(kTriangleObj);
  for (std::size_t length = 2; length < whole.size(); ++length) {
    const std::string message = refusal(whole.substr(0, length), "m.obj");
    CAPTURE(length);
    CHECK(contains(message, "truncated"));
  }
  std::string wrong_crc = whole;
  wrong_crc[whole.size() - 8] ^= 1;
  CHECK(contains(refusal(wrong_crc, "m.obj"), "damaged gzip data: incorrect data check"));
  std::string wrong_length = whole;
  wrong_length[whole.size() - 4] ^= 1;
  CHECK(contains(refusal(wrong_length, "m.obj"), "damaged gzip data: incorrect length check"));
  CHECK(contains(refusal(whole + "tail", "m.obj"), "left-over bytes after the gzip data"));
  CHECK(contains(refusal(whole + whole.substr(0, 12), "m.obj"), "truncated"));
  CHECK(contains(refusal(gzipped(whole), "m.obj"), "gzip inside gzip"));
  CHECK(contains(refusal(gzipped(""), "m.obj"), "empty file"));
}

TEST_CASE("gzip: the expanded size is limited") {
  ReadLimits limits;
  limits.max_expanded_bytes = kTriangleObj.size();
  CHECK(expand(gzipped(kTriangleObj), limits).ok());
  --limits.max_expanded_bytes;
  auto refused = expand(gzipped(kTriangleObj), limits);
  REQUIRE(!refused.ok());
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(
      contains(refused.error().message, "expands to more than " + std::to_string(kTriangleObj.size() - 1) + " bytes"));
}

TEST_CASE("gzip: a bomb ends at the limit of its ratio") {
  const auto result = expand(gzipped(repeated('\n', 80'000'000)));
  REQUIRE(!result.ok());
  CHECK(result.error().code == ErrorCode::too_large);
}

TEST_CASE("gzip: a file that is not a mesh is refused by its first bytes") {
  const std::string message = refusal(gzipped(repeated('\0', 10'000'000)), "m.obj.gz");
  CHECK(contains(message, "binary data"));
  CHECK(contains(refusal(gzipped("<html>" + std::string(1'000'000, ' ')), "m.stl.gz"), "web page"));
}

}  // namespace meshgauge::api::test
