#include "api/formats/file/file_path.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

// Returns the path, or '!' and the defect.
std::string named(std::string_view name) {
  const FilePath file = file_path_of_name(name);
  CHECK(file.path.empty() != file.defect.empty());
  return file.defect.empty() ? file.path : "!" + file.defect;
}

std::string uri(std::string_view uri) {
  const FilePath file = file_path_of_uri(uri);
  return file.defect.empty() ? file.path : "!" + file.defect;
}

std::string folders(std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += "d/";
  return out + "x.bin";
}

}  // namespace

TEST_CASE("file path: relative names of plain components") {
  CHECK(named("x.bin") == "x.bin");
  CHECK(named("./buffers//x.bin") == "buffers/x.bin");
  CHECK(named("a b.bin") == "a b.bin");
  CHECK(named("..x/x..bin/...") == "..x/x..bin/...");
  CHECK(named("%2e%2e/x.bin") == "%2e%2e/x.bin");  // a valid file name
  CHECK(named("\xC3\xA4.bin") == "\xC3\xA4.bin");
  CHECK(named("a/b:c.bin") == "a/b:c.bin");
  CHECK(named(folders(kMostFilePathFolders)) == folders(kMostFilePathFolders));
}

TEST_CASE("file path: a URI is decoded once, before anything is checked") {
  CHECK(uri("a%20b.bin") == "a b.bin");
  CHECK(uri("%C3%a4.bin") == "\xC3\xA4.bin");
  CHECK(uri("100%.bin") == "100%.bin");
  CHECK(uri("%zz%4") == "%zz%4");
  CHECK(uri("%252e%252e/x.bin") == "%2e%2e/x.bin");
  CHECK(contains(uri("%2e%2e/x.bin"), "!has '..'"));
  CHECK(contains(uri("%2E%2E%2Fetc%2Fpasswd"), "!has '..'"));
  CHECK(contains(uri("a/%2e./x.bin"), "!has '..'"));
  CHECK(contains(uri("%2Fetc%2Fpasswd"), "!is absolute"));
  CHECK(contains(uri("x%00.bin"), "!has a control character"));
  CHECK(contains(uri("http%3A//127.0.0.1/x.bin"), "!has a scheme"));
  CHECK(contains(uri("..%5cx.bin"), "!has a backslash"));
}

TEST_CASE("file path: names that may lead outside are refused") {
  for (const char* name : {"..", "../x.bin", "a/../x.bin", "a/..", "./../x.bin", "a//../../x.bin"}) {
    CHECK(contains(named(name), "!has '..'"));
  }
  for (const char* name : {"/", "/etc/passwd", "//host/share/x.bin"}) CHECK(contains(named(name), "!is absolute"));
  for (const char* name : {"http://127.0.0.1:9/x.bin", "HTTPS://h/x", "file:///etc/passwd", "C:x.bin", "c:/x.bin"}) {
    CHECK(contains(named(name), "!has a scheme, and nothing is fetched"));
  }
  for (const char* name : {"a\\x.bin", "..\\x.bin", "\\\\host\\x.bin"})
    CHECK(contains(named(name), "!has a backslash"));
  for (const char* name : {"x\n.bin", "\x7Fx", "\x1Bx"}) CHECK(contains(named(name), "!has a control character"));
  for (const char* name : {".", "./", "a/", "a/."}) CHECK(contains(named(name), "!names a folder"));
  CHECK(named("") == "!is empty");
  CHECK(contains(named(std::string(1025, 'x')), "!is longer than 1024 bytes"));
  CHECK(contains(named(folders(kMostFilePathFolders + 1)), "!has more than 32 folders"));
}

}  // namespace meshgauge::api::test
