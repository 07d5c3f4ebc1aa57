#include "cli/mcp/lines.h"

#include <unistd.h>

#include <array>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge::mcp;

namespace {

// What is read of a pipe into which `text` is written, with at most 10 bytes a line.
std::vector<std::string> lines_of(const std::string& text, std::size_t piece) {
  std::array<int, 2> ends{};
  REQUIRE(::pipe(ends.data()) == 0);
  std::thread writer([&] {
    for (std::size_t at = 0; at < text.size(); at += piece) {
      const std::string part = text.substr(at, piece);
      if (::write(ends[1], part.data(), part.size()) < 0) break;
    }
    ::close(ends[1]);
  });
  Lines lines(ends[0], 10);
  std::vector<std::string> all;
  std::string line;
  for (auto got = lines.next(line); got != Lines::Got::end; got = lines.next(line))
    all.push_back(got == Lines::Got::line ? line : "too long, id " + lines.id());
  writer.join();
  ::close(ends[0]);
  return all;
}

}  // namespace

TEST_CASE("lines: each message, however it arrives") {
  const std::string text = "one\n\ntwo two\n0123456789\n01234567890\n{\"x\":12345,\"id\":7}\nthree\nend";
  const std::vector<std::string> wanted{"one",   "",   "two two", "0123456789", "too long, id null", "too long, id 7",
                                        "three", "end"};
  for (const std::size_t piece : {std::size_t{1}, std::size_t{2}, std::size_t{7}, text.size()})
    CHECK(lines_of(text, piece) == wanted);
}

TEST_CASE("lines: a long one that does not end") {
  CHECK(lines_of(std::string(500'000, 'x'), 4096) == std::vector<std::string>{"too long, id null"});
  CHECK(lines_of("", 1).empty());
}

TEST_CASE("lines: long ones between chunks") {
  const std::string text = std::string(70'000, 'x') + "\nshort\n" + std::string(200'000, 'y') + "\nend\n";
  CHECK(lines_of(text, 4096) == std::vector<std::string>{"too long, id null", "short", "too long, id null", "end"});
}
