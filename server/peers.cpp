#include "server/peers.h"

#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>

namespace meshgauge::server {

std::optional<Peers::Place> Peers::take(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  std::uint64_t& taken = taken_[peer];
  if (taken >= most_) return std::nullopt;
  ++taken;
  return Place(this, peer);
}

void Peers::give_back(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  const auto entry = taken_.find(peer);
  if (--entry->second == 0) taken_.erase(entry);  // else every address that ever called would stay
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
