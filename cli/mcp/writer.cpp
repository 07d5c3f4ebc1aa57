#include "cli/mcp/writer.h"

#include <cerrno>
#include <span>
#include <string_view>
#include <utility>

#include "api/base/descriptor.h"

namespace meshgauge::mcp {

Writer::Writer(int file, std::size_t most_bytes, std::function<void(int error)> failed)
    : file_(file), most_bytes_(most_bytes), failed_(std::move(failed)), thread_([this] { write_lines(); }) {}

Writer::~Writer() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    changed_.notify_all();
  }
  thread_.join();
}

void Writer::send(std::string line) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return bytes_ < most_bytes_; });
  put(std::move(line));
}

void Writer::offer(std::string line) {
  const std::lock_guard lock(mutex_);
  if (bytes_ < most_bytes_) put(std::move(line));
}

bool Writer::end(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, patience, [this] { return bytes_ == 0; });
}

void Writer::put(std::string line) {
  lines_.push_back(std::move(line));
  bytes_ += lines_.back().size() + 1;
  changed_.notify_all();
}

void Writer::write_lines() {
  bool is_broken = false;
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_ending_ || !lines_.empty(); });
    if (lines_.empty()) return;
    std::string line = std::move(lines_.front());
    lines_.pop_front();
    lock.unlock();
    if (!is_broken && !write(line)) {
      is_broken = true;
      failed_(errno);
    }
    const std::size_t bytes = line.size() + 1;
    line = std::string();  // a long one is freed before another one is taken
    lock.lock();
    bytes_ -= bytes;
    changed_.notify_all();
  }
}

bool Writer::write(const std::string& line) const {
  constexpr std::string_view kEnd = "\n";
  return write_all(file_, std::as_bytes(std::span(line))) && write_all(file_, std::as_bytes(std::span(kEnd)));
}

}  // namespace meshgauge::mcp
