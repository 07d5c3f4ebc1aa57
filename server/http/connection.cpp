#include "server/http/connection.h"

#include <linux/sockios.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cassert>
#include <cstring>
#include <span>

#include "api/base/digest.h"

namespace meshgauge::server {

void Connection::consume(std::size_t n) {
  assert(n <= buffered().size());
  start_ += n;
  if (start_ == buffer_.size()) {
    buffer_.clear();
    start_ = 0;
  }
}

const std::string& Connection::peer() {
  if (peer_.empty()) peer_ = address_tag(peer_of(fd_));
  return peer_;
}

std::size_t Connection::unsent() const {
  int bytes = 0;
  return ::ioctl(fd_, SIOCOUTQNSD, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes) : 0;
}

bool Connection::take_place(ConnectionLimit& peers) {
  if (!place_) place_ = peers.take(peer_of(fd_));
  return place_ != nullptr;
}

void Connection::shrink() {
  if (buffer_.empty()) buffer_ = {};
}

Transport::Step Connection::receive(std::size_t most) {
  buffer_.erase(0, start_);
  start_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + most);
  const Transport::Moved moved = transport_->read(buffer_.data() + kept, most);
  buffer_.resize(kept + moved.bytes);
  return moved.step;
}

std::string address_tag(const std::string& address) {
  static const std::string key = api::random_id();
  const std::string keyed = key + address;
  return api::sha256_hex(std::as_bytes(std::span(keyed))).substr(0, 32);
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
