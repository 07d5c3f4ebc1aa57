#include "server/main/settings_file.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::apply_settings;
using server::Settings;

namespace {

std::string refused_file(const std::string& text) {
  Settings settings;
  const auto done = apply_settings(text, settings);
  REQUIRE_MESSAGE(!done.ok(), text);
  return done.error().message;
}

}  // namespace

TEST_CASE("settings file: names, comments and values of each type") {
  Settings settings;
  const auto done = apply_settings(
      "# a comment\n\n  port = 9090 # why\r\nhost=\"::1\"\t# a # b\npublic_without_keys = true\n"
      "temp_dir = \"a \\\"b\\\" \\\\ # c\"",
      settings);
  REQUIRE_MESSAGE(done.ok(), done.error().message);
  CHECK(settings.port == 9090);
  CHECK(settings.host == "::1");
  CHECK(settings.public_without_keys);
  CHECK(settings.temp_dir == "a \"b\" \\ # c");
  CHECK(settings.queue == Settings{}.queue);
}

TEST_CASE("settings file: invalid lines are refused with their number") {
  CHECK(refused_file("port = 1\n\nprot = 2") == "line 3: 'prot' is not a setting");
  CHECK(refused_file("port = 1\nport = 1\n") == "line 2: 'port' is set twice");
  CHECK(refused_file("[serve]") == "line 1: must be 'name = value'");
  CHECK(refused_file("= 3") == "line 1: '' is not a setting");
  CHECK(refused_file("max-part-bytes = 3") == "line 1: 'max-part-bytes' is not a setting");
  CHECK(refused_file("config = \"x\"") == "line 1: 'config' is not a setting");
  for (const char* number : {"", "-1", "1.5", "\"1\"", "1 2", "0x10", "18446744073709551616", "many"}) {
    CHECK(refused_file(std::string("port = ") + number) ==
          "line 1: 'port' must be a whole number, 0 or more, without quotes");
  }
  for (const char* text : {"", "x", "\"x", "x\"", "\"x\" y", "'x'", "\"x\\\""}) {
    CHECK(refused_file(std::string("host = ") + text) == "line 1: 'host' must be a text in double quotes");
  }
  CHECK(refused_file("host = \"\\q\"").starts_with("line 1: 'host' has an unknown escape"));
  for (const char* word : {"", "1", "yes", "\"true\"", "truely", "true false"}) {
    CHECK(refused_file(std::string("public_without_keys = ") + word) ==
          "line 1: 'public_without_keys' must be true or false");
  }
}

TEST_CASE("settings file: to_text() is read back unchanged") {
  Settings asked;
  asked.port = 7;
  asked.workers = 0;
  asked.public_without_keys = true;
  asked.temp_dir = "a \"quoted\"\tone\\ # not a comment";
  asked.cors_origins = "https://a.example";
  Settings in_force = asked;
  in_force.workers = 12;
  const std::string text = to_text(asked, in_force);
  CHECK(text.find("\nworkers = 0  # here: 12\n") != std::string::npos);
  Settings read;
  const auto done = apply_settings(text, read);
  REQUIRE_MESSAGE(done.ok(), done.error().message);
  CHECK(to_text(read, in_force) == text);
}

TEST_CASE("settings file: a password is left out, the rest of the connection string is printed") {
  Settings asked;
  const auto line = [&](const std::string& database) {
    asked.database = database;
    const std::string text = to_text(asked, asked);
    const std::size_t begin = text.find("\ndatabase = ") + 1;
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  CHECK(line("postgresql://me@one,two/x?sslmode=require") ==
        "database = \"postgresql://me@one,two/x?sslmode=require\"");
  const std::string url = line("postgresql://me:secret@one:1,two:2/x");
  CHECK(url == "database = \"user='me' dbname='x' host='one,two' port='1,2'\"  # a password is set, but not shown");
  CHECK(line("host=one password='it\\'s secret' sslpassword=secret user='a b'") ==
        "database = \"user='a b' host='one'\"  # a password is set, but not shown");
  Settings read;
  REQUIRE(apply_settings(url, read).ok());
  CHECK(read.database == "user='me' dbname='x' host='one,two' port='1,2'");
}

TEST_CASE("settings file: a file that cannot be read is an error with the reason") {
  Settings settings;
  CHECK(load_settings("/nonexistent/file", settings).error().message.find("No such file") != std::string::npos);
  CHECK(!load_settings("/tmp", settings).ok());
}
