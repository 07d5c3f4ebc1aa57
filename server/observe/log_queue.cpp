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

// A pipe takes so many bytes (PIPE_BUF) in one piece, so lines of several processes do not mix.
constexpr std::size_t kPiece = 4096;

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
  State(int to, Report what) : file(to), report(std::move(what)) {}

  const int file;
  const Report report;
  mutable std::mutex mutex;  // guards what follows
  mutable std::condition_variable changed;
  std::deque<std::string> lines;
  std::size_t bytes = 0;  // of `lines`
  bool started = false;   // the thread runs
  bool writing = false;   // it has taken lines
  bool ended = false;
  std::uint64_t dropped = 0;
  std::uint64_t untold = 0;  // dropped lines that no line tells of yet
};

LogQueue::LogQueue(int file, Report report) : state_(std::make_shared<State>(file, std::move(report))) {}

LogQueue::~LogQueue() {
  const std::lock_guard lock(state_->mutex);
  state_->ended = true;
  state_->changed.notify_all();
}

void LogQueue::add(std::string line) noexcept {
  State& state = *state_;
  const std::lock_guard lock(state.mutex);
  try {
    if (!state.started) std::thread([all = state_] { write_lines(*all); }).detach();
    state.started = true;
    if (state.bytes + line.size() <= kMostBytes) {
      const std::size_t bytes = line.size();
      state.lines.push_back(std::move(line));
      state.bytes += bytes;
      state.changed.notify_all();
      return;
    }
  } catch (const std::exception&) {
    // Neither memory nor a thread: the line is dropped, and the next one tries again.
  }
  ++state.dropped;
  ++state.untold;
}

bool LogQueue::drain(std::chrono::milliseconds most) const {
  const State& state = *state_;
  std::unique_lock lock(state.mutex);
  return state.changed.wait_for(lock, most, [&] { return state.lines.empty() && !state.writing; });
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
  std::unique_lock lock(state.mutex);
  while (true) {
    state.writing = false;
    state.changed.notify_all();
    state.changed.wait(lock, [&] { return state.ended || !state.lines.empty(); });
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
    if (state.lines.empty() && state.untold > 0) piece += state.report(std::exchange(state.untold, 0));
    lock.unlock();
    const bool written = write_all(state.file, piece);
    lock.lock();
    if (!written) state.dropped += lines;
  }
} catch (const std::exception&) {
  const std::lock_guard lock(state.mutex);
  state.started = false;  // out of memory: the next line starts another thread
  state.writing = false;
}

}  // namespace meshgauge::server
