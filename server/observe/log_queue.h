// Lines on their way to a descriptor. A thread of its own writes them, so that no caller waits for the descriptor's
// reader. It writes an idle log's line at once, and gathers those of a busy one. Lines beyond kMostBytes are dropped
// and counted. Thread safe.
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
  static constexpr std::uint64_t kMostAlike = 100;                 // a second

  // Returns the line that takes the place of so many others.
  using Report = std::function<std::string(std::uint64_t lines)>;

  // `dropped`: reports lines that found no room; `alike`: lines that add_alike() left out. Borrows the descriptor; a
  // stalled reader may keep the thread at it beyond this object's end.
  LogQueue(int file, Report dropped, Report alike);
  ~LogQueue();  // drops what waits; see drain()
  LogQueue(const LogQueue&) = delete;
  LogQueue& operator=(const LogQueue&) = delete;

  // Starts the thread, which the first line starts otherwise. Throws std::system_error: the system grants none.
  void start();
  void add(std::string line) noexcept;  // never blocks for the descriptor; drops the line without memory
  // As add(make()), kMostAlike times a second. Further lines are not made but counted; one line a second says how many.
  void add_alike(const std::function<std::string()>& make);
  // Waits until all lines are written, and the counts of those that are not. false: the time was over.
  bool drain(std::chrono::milliseconds most);
  std::uint64_t dropped() const;  // lines since the start, those that could not be written included

 private:
  struct State;
  void start_writer();
  static void write_lines(State& state);

  const std::shared_ptr<State> state_;  // shared with the thread, which a stalled reader may hold for ever
};

}  // namespace meshgauge::server
