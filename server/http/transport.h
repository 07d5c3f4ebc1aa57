// How bytes pass an accepted socket: as they are, or through TLS (server/http/tls). No call blocks.
#pragma once

#include <cstddef>
#include <string_view>

namespace meshgauge::server {

// One thread at a time.
class Transport {
 public:
  enum class Step { done, wants_read, wants_write, closed };  // wants_*: poll the socket for that, then call again

  struct Moved {
    Step step = Step::closed;
    std::size_t bytes = 0;  // more than none exactly when done
  };

  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;

  virtual Step handshake() = 0;  // until it is done: the first call
  virtual Moved read(char* out, std::size_t size) = 0;
  virtual Moved write(std::string_view bytes) = 0;  // not empty; a retry must begin with the same bytes
  virtual bool peer_gone() = 0;  // it has closed its side, or half of it, or the connection is broken
  virtual void end() = 0;        // tells the peer that nothing more will be sent
};

class PlainTransport final : public Transport {
 public:
  explicit PlainTransport(int fd) : fd_(fd) {}  // borrowed

  Step handshake() override { return Step::done; }
  Moved read(char* out, std::size_t size) override;
  Moved write(std::string_view bytes) override;
  bool peer_gone() override;
  void end() override;

 private:
  const int fd_;
};

bool peer_hung_up(int fd);

}  // namespace meshgauge::server
