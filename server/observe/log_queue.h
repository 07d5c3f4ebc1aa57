// Lines on their way to a descriptor. A thread of its own writes them, so that no caller waits for the descriptor's
// reader. Lines beyond kMostBytes are dropped and counted. Thread safe.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace meshgauge::server {

class LogQueue {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{1} << 20;  // of lines that wait

  // Returns the line that takes the place of so many dropped ones.
  using Report = std::function<std::string(std::uint64_t dropped)>;

  LogQueue(int file, Report report);  // borrows the descriptor
  ~LogQueue();                        // drops what waits; see drain()
  LogQueue(const LogQueue&) = delete;
  LogQueue& operator=(const LogQueue&) = delete;

  void add(std::string line) noexcept;               // never blocks for the descriptor; drops the line without memory
  bool drain(std::chrono::milliseconds most) const;  // waits until all lines are written; false: the time was over
  std::uint64_t dropped() const;                     // lines since the start, those that could not be written included

 private:
  struct State;
  static void write_lines(State& state);

  const std::shared_ptr<State> state_;  // shared with the thread, which a stalled reader may hold for ever
};

}  // namespace meshgauge::server
