#include "server/http/lingering_close.h"

#include <sys/socket.h>

#include <cerrno>
#include <utility>

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kRound{5};
constexpr std::size_t kPiece = std::size_t{1} << 20;

// Discards what has arrived. False: the client has closed, or has sent kMostBytes.
bool drain(int fd, std::size_t& drained) {
  while (drained < LingeringClose::kMostBytes) {
    const ssize_t n = ::recv(fd, nullptr, kPiece, MSG_DONTWAIT | MSG_TRUNC);  // TCP discards them without copying
    if (n == 0) return false;
    if (n < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    drained += static_cast<std::size_t>(n);
  }
  return false;
}

}  // namespace

LingeringClose::LingeringClose(std::size_t most) : most_(most), thread_([this] { run(); }) {}

LingeringClose::~LingeringClose() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void LingeringClose::take(Descriptor socket) {
  const std::lock_guard lock(mutex_);
  if (aborted_) return;
  if (closings_.size() >= most_) closings_.pop_front();
  closings_.push_back({std::move(socket), Clock::now() + kTime, 0});
  if (closings_.size() == 1) changed_.notify_one();
}

void LingeringClose::abort() {
  const std::lock_guard lock(mutex_);
  aborted_ = true;
  closings_.clear();
}

std::size_t LingeringClose::size() const {
  const std::lock_guard lock(mutex_);
  return closings_.size();
}

void LingeringClose::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ending_ || !closings_.empty(); });
    if (closings_.empty()) return;
    const auto now = Clock::now();
    std::erase_if(closings_,
                  [&](Closing& one) { return one.deadline <= now || !drain(one.socket.get(), one.drained); });
    lock.unlock();
    std::this_thread::sleep_for(kRound);
    lock.lock();
  }
}

}  // namespace meshgauge::server
