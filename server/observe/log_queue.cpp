#include "server/observe/log_queue.h"

#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string_view>
#include <thread>
#include <utility>

namespace meshgauge::server {
namespace {

using Clock = std::chrono::steady_clock;

// A pipe takes so many bytes (PIPE_BUF) in one piece, so lines of several processes do not mix.
constexpr std::size_t kPiece = 4096;
// A busy log's writer rests between two pieces, since it takes a processor from those that work.
constexpr std::chrono::milliseconds kRest{5};
constexpr std::chrono::seconds kSecond{1};

// false: the descriptor does not take it.
bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n > 0) text.remove_prefix(static_cast<std::size_t>(n));
    if (n > 0 || errno == EINTR) continue;
    pollfd ready{file, POLLOUT, 0};
    if (errno != EAGAIN || (::poll(&ready, 1, -1) < 0 && errno != EINTR)) return false;
  }
  return true;
}

}  // namespace

struct LogQueue::State {
  State(int to, Report of_dropped, Report of_alike)
      : file(to), report_dropped(std::move(of_dropped)), report_alike(std::move(of_alike)) {}

  // Precondition of all functions: mutex is held.
  // Whether the thread has something to write.
  bool is_due() const { return ended || !lines.empty() || (left_out > 0 && Clock::now() >= report_at); }
  void await_lines(std::unique_lock<std::mutex>& lock);
  void wake_writer();
  bool take_alike();
  void report();

  const int file;
  const Report report_dropped;
  const Report report_alike;
  mutable std::mutex mutex;  // guards what follows
  mutable std::condition_variable written;
  std::condition_variable wake;
  std::deque<std::string> lines;
  std::size_t bytes = 0;  // of `lines`
  bool started = false;   // the thread runs
  bool idle = false;      // it waits for a line
  bool writing = false;   // it has taken lines
  bool ended = false;
  std::uint64_t dropped = 0;
  std::uint64_t untold = 0;    // dropped lines that no line tells of yet
  Clock::time_point second{};  // since when `alike` counts
  std::uint64_t alike = 0;
  std::uint64_t left_out = 0;     // by take_alike(), and no line tells of them yet
  Clock::time_point report_at{};  // when one does
};

void LogQueue::State::await_lines(std::unique_lock<std::mutex>& lock) {
  while (!is_due()) {
    idle = true;
    if (left_out > 0) {
      wake.wait_until(lock, report_at);
    } else {
      wake.wait(lock);
    }
  }
  idle = false;
}

void LogQueue::State::wake_writer() {
  if (std::exchange(idle, false)) wake.notify_one();
}

// Adds the lines that tell of those that were dropped or left out, when they are due.
void LogQueue::State::report() {
  const auto put = [&](std::string line) {
    bytes += line.size();
    lines.push_back(std::move(line));
  };
  if (untold > 0) put(report_dropped(std::exchange(untold, 0)));
  if (left_out > 0 && Clock::now() >= report_at) put(report_alike(std::exchange(left_out, 0)));
}

// false: there were enough of such lines in this second; this one is counted.
bool LogQueue::State::take_alike() {
  const auto now = Clock::now();
  if (now >= second + kSecond) {
    second = now;
    alike = 0;
  }
  if (++alike <= kMostAlike) return true;
  if (left_out++ == 0) {
    report_at = now + kSecond;
    wake_writer();
  }
  return false;
}

LogQueue::LogQueue(int file, Report dropped, Report alike)
    : state_(std::make_shared<State>(file, std::move(dropped), std::move(alike))) {}

LogQueue::~LogQueue() {
  const std::lock_guard lock(state_->mutex);
  state_->ended = true;
  state_->wake.notify_one();
}

void LogQueue::start() {
  const std::lock_guard lock(state_->mutex);
  start_writer();
}

// Precondition: the mutex is held.
void LogQueue::start_writer() {
  if (state_->started) return;
  std::thread([all = state_] { write_lines(*all); }).detach();
  state_->started = true;
}

void LogQueue::add_alike(const std::function<std::string()>& make) {
  const bool taken = [&] {
    const std::lock_guard lock(state_->mutex);
    return state_->take_alike();
  }();
  if (taken) add(make());
}

void LogQueue::add(std::string line) noexcept {
  State& state = *state_;
  const std::lock_guard lock(state.mutex);
  try {
    start_writer();
    if (state.bytes + line.size() <= kMostBytes) {
      const std::size_t bytes = line.size();
      state.lines.push_back(std::move(line));
      state.bytes += bytes;
      state.wake_writer();
      return;
    }
  } catch (const std::exception&) {
    // Neither memory nor a thread: the line is dropped, and the next one tries again.
  }
  ++state.dropped;
  ++state.untold;
}

bool LogQueue::drain(std::chrono::milliseconds most) {
  State& state = *state_;
  std::unique_lock lock(state.mutex);
  state.report_at = Clock::now();
  state.wake_writer();
  return state.written.wait_for(lock, most,
                                [&] { return state.lines.empty() && state.left_out == 0 && !state.writing; });
}

std::uint64_t LogQueue::dropped() const {
  const std::lock_guard lock(state_->mutex);
  return state_->dropped;
}

// Joins lines to pieces: a busy service logs more lines than a reader likes to be woken for.
void LogQueue::write_lines(State& state) try {
  sigset_t pipe;
  ::sigemptyset(&pipe);
  ::sigaddset(&pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe, nullptr);  // a reader that is gone is an error of write(), not the end
  Clock::time_point rested{};
  std::unique_lock lock(state.mutex);
  while (true) {
    state.writing = false;
    state.written.notify_all();
    state.await_lines(lock);
    if (state.bytes < kPiece) state.wake.wait_until(lock, rested, [&] { return state.ended; });
    if (state.ended) return;
    state.writing = true;
    std::string piece;
    std::uint64_t lines = 0;
    while (!state.lines.empty() && (lines == 0 || piece.size() + state.lines.front().size() <= kPiece)) {
      piece += state.lines.front();
      state.bytes -= state.lines.front().size();
      state.lines.pop_front();
      ++lines;
    }
    if (state.lines.empty()) state.report();
    lock.unlock();
    const bool written = write_all(state.file, piece);
    rested = Clock::now() + kRest;
    lock.lock();
    if (!written) state.dropped += lines;
  }
} catch (const std::exception&) {
  const std::lock_guard lock(state.mutex);
  state.started = state.idle = false;  // out of memory: the next line starts another thread
  state.writing = false;
}

}  // namespace meshgauge::server
