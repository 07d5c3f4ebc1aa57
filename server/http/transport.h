// Reads and writes an accepted socket, as plain bytes or through TLS (server/http/tls). No call blocks.
#pragma once

#include <cstddef>
#include <string_view>

namespace meshgauge::server {

// Not thread safe.
class Transport {
 public:
  // wants_read, wants_write: poll the socket for it, then call again. wants_thread: the next call of handshake() takes
  // a millisecond of a processor; make it on a thread that may.
  enum class Step { done, wants_read, wants_write, wants_thread, closed };

  struct Moved {
    Step step = Step::closed;
    std::size_t bytes = 0;  // 0 unless step is done
  };

  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;

  virtual Step handshake() = 0;  // before anything else; call until it is done. It alone wants a thread
  virtual Moved read(char* out, std::size_t size) = 0;
  virtual Moved write(std::string_view bytes) = 0;  // precondition: not empty; a retry starts with the same bytes
  virtual Moved discard(std::size_t most) = 0;      // reads and forgets up to `most` bytes
  virtual bool peer_gone() = 0;  // the peer has closed its side, or half of it, or the connection is broken
  virtual void end() = 0;        // tells the peer that nothing more will be sent
};

class PlainTransport final : public Transport {
 public:
  explicit PlainTransport(int fd) : fd_(fd) {}  // borrows fd

  Step handshake() override { return Step::done; }
  Moved read(char* out, std::size_t size) override;
  Moved write(std::string_view bytes) override;
  Moved discard(std::size_t most) override;
  bool peer_gone() override;
  void end() override;

 private:
  const int fd_;
};

bool peer_hung_up(int fd);  // true: the peer has shut down its sending direction, or the socket has an error

}  // namespace meshgauge::server
