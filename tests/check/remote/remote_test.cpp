#include "check/remote.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

struct KeyFile {
  explicit KeyFile(const std::string& text)
      : path(std::filesystem::temp_directory_path() / ("meshgauge-key-" + std::to_string(getpid()))) {
    std::ofstream(path, std::ios::binary) << text;
  }
  ~KeyFile() { std::filesystem::remove(path); }
  KeyFile(const KeyFile&) = delete;
  KeyFile& operator=(const KeyFile&) = delete;

  const std::filesystem::path path;
};

}  // namespace

TEST_CASE("remote: the key of a file, without what an editor puts around it") {
  CHECK(*service_key(KeyFile("mg_sesame\n").path) == "mg_sesame");
  CHECK(*service_key(KeyFile(" \tmg_sesame\r\n\r\n").path) == "mg_sesame");
}

TEST_CASE("remote: a file without a key is refused by its name") {
  for (const std::string& text : {std::string(), std::string("\n"), std::string("mg_se\nmg_same"),
                                  std::string("sesame\x01"), std::string(10'000, 'x') + " y"}) {
    const auto key = service_key(KeyFile(text).path);
    REQUIRE_FALSE(key.ok());
    CHECK(key.error().message.find("meshgauge-key-") != std::string::npos);
    CHECK(key.error().message.find("sesame") == std::string::npos);
  }
  CHECK_FALSE(service_key("/nowhere/key").ok());
  CHECK_FALSE(service_key("/").ok());
}

TEST_CASE("remote: the key of the variable, when there is no file") {
  REQUIRE(setenv("MESHGAUGE_KEY", "mg_variable\n", 1) == 0);
  CHECK(*service_key("") == "mg_variable");
  CHECK(*service_key(KeyFile("mg_file").path) == "mg_file");
  REQUIRE(unsetenv("MESHGAUGE_KEY") == 0);
  CHECK(service_key("")->empty());
}

TEST_CASE("remote: a key is sent over http to this machine only, unless allowed") {
  RemoteOptions options;
  options.url = "http://ci.example";
  CHECK(remote(options).ok());  // no key
  options.key = "mg_sesame";
  const auto made = remote(options);
  REQUIRE_FALSE(made.ok());
  CHECK(made.error().code == ErrorCode::invalid_request);
  CHECK(made.error().message.find("--key-in-clear") != std::string::npos);
  CHECK(made.error().message.find("sesame") == std::string::npos);
  options.key_in_clear = true;
  CHECK(remote(options).ok());
  options.key_in_clear = false;
  for (const char* url : {"https://ci.example", "http://127.0.0.1:8080"}) {
    options.url = url;
    CHECK(remote(options).ok());
  }
}

TEST_CASE("remote: unusable options are refused before anything is sent") {
  RemoteOptions options;
  options.url = "localhost:8080";
  CHECK_FALSE(remote(options).ok());
  options.url = "http://localhost:8080";
  options.key = "mg_ses\r\name";
  const auto made = remote(options);
  REQUIRE_FALSE(made.ok());
  CHECK(made.error().message.find("ses") == std::string::npos);
  options.key = "mg_sesame";
  options.at_once = 7;
  REQUIRE(remote(options).ok());
  CHECK((*remote(options))->at_once() == 7);
}
