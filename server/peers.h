// How many connections of each client address are being waited for. Thread safe.
//
// A slow client costs a thread for as long as its bytes are waited for. Deadlines bound that for one connection; this
// bounds it for one address, so that no single one can hold every thread.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

namespace meshgauge::server {

class Peers {
 public:
  // One connection's share; given back when it is destroyed.
  class Place {
   public:
    Place(Place&& other) noexcept : peers_(std::exchange(other.peers_, nullptr)), peer_(std::move(other.peer_)) {}
    Place& operator=(Place&&) = delete;
    ~Place() {
      if (peers_) peers_->give_back(peer_);
    }

   private:
    friend class Peers;
    Place(Peers* peers, std::string peer) : peers_(peers), peer_(std::move(peer)) {}
    Peers* peers_;
    std::string peer_;
  };

  explicit Peers(std::uint64_t most) : most_(most) {}  // places for each address; must outlive them

  std::optional<Place> take(const std::string& peer);  // nullopt: this address has all that it may have

 private:
  void give_back(const std::string& peer);

  const std::uint64_t most_;
  std::mutex mutex_;
  std::map<std::string, std::uint64_t> taken_;  // never 0
};

// The address at the other end, as bytes to compare: of IPv4 all 4, of IPv6 the first 8, since a single host is given
// that many of the rest. Empty for every other kind of socket, and one that is no longer connected.
std::string peer_of(int fd);

}  // namespace meshgauge::server
