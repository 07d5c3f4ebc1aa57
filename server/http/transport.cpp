#include "server/http/transport.h"

#include <poll.h>
#include <sys/socket.h>

#include <cerrno>

namespace meshgauge::server {
namespace {

Transport::Step wants_or_closed(Transport::Step wants) {
  return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? wants : Transport::Step::closed;
}

}  // namespace

bool peer_hung_up(int fd) {
  pollfd entry{fd, POLLRDHUP, 0};
  return ::poll(&entry, 1, 0) > 0;  // POLLHUP and POLLERR are always reported
}

Transport::Moved PlainTransport::read(char* out, std::size_t size) {
  const ssize_t n = ::recv(fd_, out, size, MSG_DONTWAIT);
  if (n > 0) return {Step::done, static_cast<std::size_t>(n)};
  return {n == 0 ? Step::closed : wants_or_closed(Step::wants_read), 0};
}

Transport::Moved PlainTransport::write(std::string_view bytes) {
  const ssize_t n = ::send(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  if (n > 0) return {Step::done, static_cast<std::size_t>(n)};
  return {wants_or_closed(Step::wants_write), 0};
}

// TCP discards them without copying.
Transport::Moved PlainTransport::discard(std::size_t most) {
  const ssize_t n = ::recv(fd_, nullptr, most, MSG_DONTWAIT | MSG_TRUNC);
  if (n > 0) return {Step::done, static_cast<std::size_t>(n)};
  return {n == 0 ? Step::closed : wants_or_closed(Step::wants_read), 0};
}

bool PlainTransport::peer_gone() { return peer_hung_up(fd_); }

void PlainTransport::end() { ::shutdown(fd_, SHUT_WR); }

}  // namespace meshgauge::server
