// Writes messages to a stream, one on a line, on a thread of its own: while the client does not read, no other thread
// waits until there is a lot to be written.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace meshgauge::mcp {

// Thread safe.
class Writer {
 public:
  // Borrows the descriptor. `failed` is called once, on the writer's thread, with the errno when the descriptor cannot
  // be written; all lines are dropped then. Throws std::system_error when there is no thread to be had.
  Writer(int file, std::size_t most_bytes, std::function<void(int error)> failed);
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;
  ~Writer();  // waits until all is written

  void send(std::string line);   // waits while there are `most_bytes` to be written
  void offer(std::string line);  // drops the line where send() would wait

  // Returns whether all is written within `patience`.
  bool end(std::chrono::milliseconds patience);

 private:
  void put(std::string line);  // precondition: mutex_ is held
  void write_lines();
  bool write(const std::string& line) const;

  const int file_;
  const std::size_t most_bytes_;
  const std::function<void(int error)> failed_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<std::string> lines_;
  std::size_t bytes_ = 0;  // of these, and of the line that is being written
  bool is_ending_ = false;
  std::thread thread_;  // last member: it uses all members above
};

}  // namespace meshgauge::mcp
