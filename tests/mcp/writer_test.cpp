#include "cli/mcp/writer.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <string>
#include <thread>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"

using namespace meshgauge;
using namespace meshgauge::mcp;

namespace {

constexpr std::chrono::minutes kPatient{1};

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    REQUIRE(::pipe(ends.data()) == 0);
    from = Descriptor(ends[0]);
    to = Descriptor(ends[1]);
  }
  // Reads until the text ends so.
  std::string read_to(const std::string& end) const {
    std::string text;
    std::array<char, 4096> piece{};
    while (!text.ends_with(end)) {
      const ssize_t count = ::read(from.get(), piece.data(), piece.size());
      REQUIRE(count > 0);
      text.append(piece.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

  Descriptor from, to;
};

}  // namespace

TEST_CASE("writer: while nothing is read no line is written, and what is offered is dropped") {
  const Pipe stream;
  const std::string large(1 << 20, 'x');  // more than a pipe holds
  Writer writer(stream.to.get(), 100, [](int) {});
  writer.send(large);
  writer.offer("dropped");
  CHECK_FALSE(writer.end(std::chrono::milliseconds(1)));
  std::thread sender([&] { writer.send("second"); });  // waits
  CHECK(stream.read_to("second\n") == large + "\nsecond\n");
  sender.join();
  CHECK(writer.end(kPatient));
  writer.offer("third");
  CHECK(stream.read_to("\n") == "third\n");
}

TEST_CASE("writer: when the reader has gone that is told once, and nothing waits") {
  Pipe stream;
  std::signal(SIGPIPE, SIG_IGN);
  std::atomic<int> told{0}, error{0};
  {
    Writer writer(stream.to.get(), 1, [&](int why) {
      error = why;
      ++told;
    });
    stream.from.close();
    for (int i = 0; i < 10; ++i) writer.send("line");
    CHECK(writer.end(kPatient));
  }
  CHECK(told == 1);
  CHECK(error == EPIPE);
}
