#include "server/http/connection.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kAbortTick{50};

int ms_until(Clock::time_point deadline) {
  const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now());
  return static_cast<int>(std::clamp(left, milliseconds(0), kAbortTick).count());
}

bool is_ready(int fd, short events) {
  pollfd entry{fd, events, 0};
  return ::poll(&entry, 1, 0) > 0;
}

short events_of(Transport::Step wants) { return wants == Transport::Step::wants_write ? POLLOUT : POLLIN; }

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
  if (peers_ && !place_) place_ = peers_->take(peer_of(fd_));
  return !peers_ || place_;
}

Io Connection::wait(short events, Clock::time_point deadline, Counted counted, const std::function<bool()>& give_up) {
  if (counted == Counted::yes && !is_ready(fd_, events) && !take_place()) return Io::peer_limit;
  for (;;) {
    pollfd entry{fd_, events, 0};
    const int ready = ::poll(&entry, 1, ms_until(deadline));
    if (ready > 0) return Io::ok;
    if (ready < 0 && errno != EINTR) return Io::closed;
    if (Clock::now() >= deadline) return Io::timeout;
    if (aborted_.load()) return Io::aborted;
    if (give_up && give_up()) return Io::timeout;
  }
}

Io Connection::first_byte(char& byte, Clock::time_point deadline, const std::function<bool()>& give_up) {
  if (const Io io = wait(POLLIN, deadline, Counted::no, give_up); io != Io::ok) return io;
  return ::recv(fd_, &byte, 1, MSG_DONTWAIT | MSG_PEEK) == 1 ? Io::ok : Io::closed;
}

Io Connection::secure(std::unique_ptr<Transport> transport, Clock::time_point deadline) {
  transport_ = std::move(transport);
  for (;;) {
    const Transport::Step step = transport_->handshake();
    if (step == Transport::Step::done) return Io::ok;
    if (step == Transport::Step::closed) return Io::closed;
    if (Clock::now() >= deadline) return Io::timeout;  // also when bytes keep coming
    if (const Io io = wait(events_of(step), deadline, Counted::yes, nullptr); io != Io::ok) return io;
  }
}

Io Connection::fill(Clock::time_point deadline, std::size_t most) {
  return receive(most, deadline, Counted::yes, nullptr);
}

Io Connection::idle(Clock::time_point deadline, const std::function<bool()>& give_up) {
  return receive(kHeadPiece, deadline, Counted::no, give_up);
}

Io Connection::receive(std::size_t most, Clock::time_point deadline, Counted counted,
                       const std::function<bool()>& give_up) {
  buffer_.erase(0, start_);
  start_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + most);
  std::size_t got = 0;
  const Io io = read(std::span(buffer_).subspan(kept), got, deadline, counted, give_up);
  buffer_.resize(kept + got);
  return io;
}

Io Connection::read(std::span<char> out, std::size_t& got, Clock::time_point deadline, Counted counted,
                    const std::function<bool()>& give_up) {
  for (;;) {
    if (Clock::now() >= deadline) return Io::timeout;  // also when bytes keep coming
    const Transport::Moved moved = transport_->read(out.data(), out.size());
    got = moved.bytes;
    if (moved.step == Transport::Step::done) return Io::ok;
    if (moved.step == Transport::Step::closed) return Io::closed;
    if (const Io io = wait(events_of(moved.step), deadline, counted, give_up); io != Io::ok) return io;
  }
}

Io Connection::write(std::string_view bytes, Clock::time_point deadline, Counted counted) {
  while (!bytes.empty()) {
    const Transport::Moved moved = transport_->write(bytes);
    bytes.remove_prefix(moved.bytes);
    if (moved.step == Transport::Step::done) continue;
    if (moved.step == Transport::Step::closed) return Io::closed;
    if (const Io io = wait(events_of(moved.step), deadline, counted, nullptr); io != Io::ok) return io;
  }
  return Io::ok;
}

std::string peer_of(int fd) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (::getpeername(fd, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return {};
  if (storage.ss_family == AF_INET) {
    sockaddr_in address{};
    std::memcpy(&address, &storage, sizeof address);
    return {reinterpret_cast<const char*>(&address.sin_addr), 4};
  }
  if (storage.ss_family != AF_INET6) return {};
  sockaddr_in6 address{};
  std::memcpy(&address, &storage, sizeof address);
  const char* bytes = reinterpret_cast<const char*>(&address.sin6_addr);
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) return {bytes + 12, 4};
  return {bytes, 8};
}

}  // namespace meshgauge::server
