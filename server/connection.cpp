#include "server/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cassert>
#include <cerrno>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kPiece = std::size_t{64} << 10;
constexpr milliseconds kTick{50};
constexpr milliseconds kShortLinger{50};

int ms_until(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
  return static_cast<int>(std::clamp(left, milliseconds(0), kTick).count());
}

bool is_ready(int fd, short events) {
  pollfd entry{fd, events, 0};
  return ::poll(&entry, 1, 0) > 0;
}

bool again(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

}  // namespace

void Connection::consume(std::size_t n) {
  assert(n <= buffered().size());
  start_ += n;
  if (start_ == buffer_.size()) {
    buffer_.clear();
    start_ = 0;
  }
}

bool Connection::take_place() {
  if (peers_ && !place_) {
    if (auto place = peers_->take(peer_of(fd_))) place_.emplace(std::move(*place));
  }
  return !peers_ || place_;
}

Io Connection::wait(short events, Clock::time_point deadline, Counted counted, const std::function<bool()>& give_up) {
  if (counted == Counted::yes && !is_ready(fd_, events) && !take_place()) return Io::crowded;
  for (;;) {
    pollfd entry{fd_, events, 0};
    const int ready = ::poll(&entry, 1, ms_until(deadline));
    if (ready > 0) return Io::ok;
    if (ready < 0 && errno != EINTR) return Io::closed;
    if (aborted_.load() || Clock::now() >= deadline) return Io::timeout;
    if (give_up && give_up()) return Io::timeout;
  }
}

Io Connection::fill(Clock::time_point deadline) { return receive(deadline, Counted::yes, nullptr); }

Io Connection::idle(Clock::time_point deadline, const std::function<bool()>& give_up) {
  return receive(deadline, Counted::no, give_up);
}

Io Connection::receive(Clock::time_point deadline, Counted counted, const std::function<bool()>& give_up) {
  buffer_.erase(0, start_);
  start_ = 0;
  const std::size_t kept = buffer_.size();
  for (;;) {
    if (Clock::now() >= deadline) return Io::timeout;  // also when bytes keep coming
    if (const Io io = wait(POLLIN, deadline, counted, give_up); io != Io::ok) return io;
    buffer_.resize(kept + kPiece);
    const ssize_t n = ::recv(fd_, buffer_.data() + kept, kPiece, MSG_DONTWAIT);
    const int error = errno;
    buffer_.resize(kept + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    if (n > 0) return Io::ok;
    if (n == 0 || !again(error)) return Io::closed;
  }
}

Io Connection::write(std::string_view bytes, Clock::time_point deadline) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
      continue;
    }
    if (n < 0 && !again(errno)) return Io::closed;
    if (const Io io = wait(POLLOUT, deadline, Counted::yes, nullptr); io != Io::ok) return io;
  }
  return Io::ok;
}

bool Connection::peer_gone() const { return is_ready(fd_, POLLRDHUP); }  // POLLHUP and POLLERR are always reported

void Connection::linger(milliseconds time) {
  ::shutdown(fd_, SHUT_WR);
  constexpr std::size_t kMost = std::size_t{16} << 20;
  const auto deadline = Clock::now() + (take_place() ? time : std::min(time, kShortLinger));
  buffer_.clear();
  start_ = 0;
  for (std::size_t drained = 0; drained < kMost && receive(deadline, Counted::no, nullptr) == Io::ok;) {
    drained += buffered().size();
    consume(buffered().size());
  }
}

}  // namespace meshgauge::server
