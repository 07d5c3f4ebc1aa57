#include "server/http/lingering_close.h"

#include <doctest/doctest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <string>
#include <thread>
#include <vector>

namespace meshgauge::server {
namespace {

// Both ends of a TCP connection; other kinds of sockets are never reset.
struct Ends {
  Descriptor ours, theirs;
};

class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    address_.sin_family = AF_INET;
    address_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address_), sizeof address_) == 0);
    REQUIRE(::listen(socket_.get(), 16) == 0);
    socklen_t size = sizeof address_;
    REQUIRE(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&address_), &size) == 0);
  }

  Ends connect() {
    Descriptor theirs(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    REQUIRE(::connect(theirs.get(), reinterpret_cast<sockaddr*>(&address_), sizeof address_) == 0);
    Descriptor ours(::accept(socket_.get(), nullptr, nullptr));
    REQUIRE(ours);
    return {std::move(ours), std::move(theirs)};
  }

 private:
  Descriptor socket_;
  sockaddr_in address_{};
};

void answer(const Ends& ends, const std::string& text) {
  REQUIRE(::send(ends.ours.get(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
  REQUIRE(::shutdown(ends.ours.get(), SHUT_WR) == 0);
}

// Sends until the other side takes no more.
void flood(int fd) {
  const std::vector<char> bytes(1 << 16, 'x');
  while (::send(fd, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL) > 0) {
  }
}

std::string read_all(int fd) {
  std::string text(64, '\0');
  std::size_t got = 0;
  for (;;) {
    const ssize_t n = ::recv(fd, text.data() + got, text.size() - got, 0);
    if (n <= 0) return n < 0 ? "reset" : text.substr(0, got);
    got += static_cast<std::size_t>(n);
  }
}

// True if the other side has closed both directions: sending is then answered by a reset.
bool is_closed(int fd) {
  const char byte = 'x';
  (void)::send(fd, &byte, 1, MSG_NOSIGNAL);
  pollfd entry{fd, 0, 0};
  return ::poll(&entry, 1, 10) > 0 && (entry.revents & (POLLHUP | POLLERR)) != 0;
}

TEST_CASE("lingering: a client that has sent unread bytes still gets its response") {
  Listener listener;
  LingeringClose lingering;
  Ends ends = listener.connect();
  flood(ends.theirs.get());  // closing now would reset the connection
  answer(ends, "no");
  lingering.take(std::move(ends.ours));
  flood(ends.theirs.get());
  CHECK(read_all(ends.theirs.get()) == "no");
  ends.theirs.close();
  while (lingering.size() > 0) std::this_thread::yield();
}

TEST_CASE("lingering: a client that never closes is dropped after its time") {
  Listener listener;
  LingeringClose lingering;
  Ends ends = listener.connect();
  answer(ends, "no");
  lingering.take(std::move(ends.ours));
  CHECK(read_all(ends.theirs.get()) == "no");
  while (lingering.size() > 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  while (!is_closed(ends.theirs.get())) {
  }
}

TEST_CASE("lingering: a client that sends without end is dropped") {
  Listener listener;
  LingeringClose lingering;
  Ends ends = listener.connect();
  answer(ends, "no");
  lingering.take(std::move(ends.ours));
  const std::vector<char> bytes(1 << 16, 'x');
  std::size_t sent = 0;
  while (::send(ends.theirs.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) > 0) sent += bytes.size();
  CHECK(sent < 4 * LingeringClose::kMostBytes);  // and what the kernel's buffers take
}

TEST_CASE("lingering: beyond the maximum the oldest connection is closed") {
  constexpr std::size_t most = 5;
  Listener listener;
  LingeringClose lingering(most);
  std::vector<Ends> all;
  for (std::size_t i = 0; i < most + 3; ++i) {
    all.push_back(listener.connect());
    answer(all.back(), "no");
    lingering.take(std::move(all.back().ours));
  }
  CHECK(lingering.size() <= most);
  for (const Ends& ends : all) CHECK(read_all(ends.theirs.get()) == "no");
}

TEST_CASE("lingering: abort() closes every connection at once") {
  Listener listener;
  LingeringClose lingering;
  Ends before = listener.connect();
  Ends after = listener.connect();
  lingering.take(std::move(before.ours));
  lingering.abort();
  while (lingering.size() > 0) std::this_thread::yield();
  lingering.take(std::move(after.ours));
  CHECK(lingering.size() == 0);
  CHECK(read_all(after.theirs.get()).empty());
}

}  // namespace
}  // namespace meshgauge::server
