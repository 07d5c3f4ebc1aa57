// The log's lines arrive in order and whole, and a reader that stalls stops no caller.
#include "server/observe/log_queue.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"
using namespace meshgauge;
using namespace meshgauge::server;
using namespace std::chrono_literals;

namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0);
    reader = Descriptor(ends[0]);
    writer = Descriptor(ends[1]);
  }
  // What arrives until the text ends with `last`.
  std::string read_until(const std::string& last) const {
    std::string text;
    std::array<char, 4096> piece{};
    while (!text.ends_with(last)) {
      const ssize_t n = ::read(reader.get(), piece.data(), piece.size());
      if (n <= 0) return text;
      text.append(piece.data(), static_cast<std::size_t>(n));
    }
    return text;
  }
  Descriptor reader, writer;
};

std::string told(std::uint64_t lines) { return "dropped " + std::to_string(lines) + "\n"; }

std::string left_out(std::uint64_t lines) { return "left out " + std::to_string(lines) + "\n"; }

}  // namespace

TEST_CASE("log: lines that are alike beyond a hundred a second are counted, and the log says so by itself") {
  const Pipe pipe;
  LogQueue queue(pipe.writer.get(), told, left_out);
  for (std::uint64_t i = 0; i < 3 * LogQueue::kMostAlike; ++i) queue.add_alike([] { return "alike\n"; });
  const std::string text = pipe.read_until("left out " + std::to_string(2 * LogQueue::kMostAlike) + "\n");
  CHECK(text.size() == LogQueue::kMostAlike * 6 + left_out(2 * LogQueue::kMostAlike).size());
  queue.add_alike([] { return "end\n"; });  // in another second
  CHECK(pipe.read_until("end\n") == "end\n");
}

TEST_CASE("log: what was left out is told before a queue is drained") {
  const Pipe pipe;
  LogQueue queue(pipe.writer.get(), told, left_out);
  for (std::uint64_t i = 0; i < LogQueue::kMostAlike + 5; ++i) queue.add_alike([] { return "alike\n"; });
  CHECK(queue.drain(10s));
  queue.add("end\n");
  CHECK(pipe.read_until("end\n").find("left out ") != std::string::npos);
}

TEST_CASE("log: lines of several threads arrive whole, those of each thread in order") {
  const Pipe pipe;
  LogQueue queue(pipe.writer.get(), told, left_out);
  std::vector<std::thread> threads;
  for (char name = 'a'; name < 'e'; ++name) {
    threads.emplace_back([&queue, name] {
      for (int i = 0; i < 50; ++i) queue.add(std::string(1, name) + std::to_string(i) + "\n");
    });
  }
  for (std::thread& thread : threads) thread.join();
  queue.add("end\n");
  const std::string text = pipe.read_until("end\n");
  for (char name = 'a'; name < 'e'; ++name) {
    std::size_t at = 0;
    for (int i = 0; i < 50; ++i) {
      at = text.find(std::string(1, name) + std::to_string(i) + "\n", at);
      CHECK(at != std::string::npos);
    }
  }
  CHECK(queue.drain(10s));
  CHECK(queue.dropped() == 0);
}

TEST_CASE("log: a stalled reader stops no caller, lines are dropped and counted, and the log says so afterwards") {
  const Pipe pipe;
  LogQueue queue(pipe.writer.get(), told, left_out);
  const std::string line = std::string(999, 'x') + "\n";
  for (std::size_t bytes = 0; bytes < 2 * LogQueue::kMostBytes; bytes += line.size()) queue.add(line);
  const std::uint64_t dropped = queue.dropped();
  CHECK(dropped > LogQueue::kMostBytes / line.size() / 2);
  CHECK_FALSE(queue.drain(1ms));
  std::thread last([&] {
    while (!queue.drain(10ms)) {
    }
    queue.add("end\n");
  });
  const std::string text = pipe.read_until("end\n");
  last.join();
  CHECK(text.find(told(dropped)) != std::string::npos);
  CHECK(queue.dropped() == dropped);
}

TEST_CASE("log: lines to a closed pipe are dropped and counted") {
  Pipe pipe;
  pipe.reader = Descriptor();
  LogQueue queue(pipe.writer.get(), told, left_out);
  queue.add("line\n");
  CHECK(queue.drain(10s));
  CHECK(queue.dropped() == 1);
}

TEST_CASE("log: a queue ends while its reader stalls") {
  static const Pipe& pipe = *new Pipe;  // for ever: the queue's thread still writes to it
  LogQueue queue(pipe.writer.get(), told, left_out);
  for (int i = 0; i < 200; ++i) queue.add(std::string(999, 'x') + "\n");
  CHECK_FALSE(queue.drain(1ms));
}
