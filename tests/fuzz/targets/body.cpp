// The body of a request as it comes from a socket: the first byte says whether it is chunked or how long it is, the
// rest is what the client sends before it closes. Asserted: however the bytes are cut into packets, the same body is
// received, the same refusal given and the same rest left for the next request; the body is within its limit.
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

#include "server/http/body.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

constexpr std::uint64_t kMostBytes = 2000;
constexpr std::size_t kLongestInput = 8192;
constexpr std::size_t kMostPackets = 32;  // as many as a socket holds until they are read

// Both ends of a connection that keeps packets apart. The client's has sent everything and is closed.
class Client {
 public:
  Client(std::string_view sent, std::size_t longest, Dice& dice) {
    require(::socketpair(AF_UNIX, SOCK_SEQPACKET, 0, ends_.data()) == 0, "a socket pair");
    in_pieces(sent, longest, dice, [&](std::string_view packet) {
      const ssize_t n = ::send(ends_[1], packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      require(n == static_cast<ssize_t>(packet.size()), "the socket holds what is sent");
      return true;
    });
    ::close(ends_[1]);
  }
  ~Client() { ::close(ends_[0]); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  int end() const { return ends_[0]; }

 private:
  std::array<int, 2> ends_{-1, -1};
};

std::string rest_of(server::Connection& connection) {
  while (connection.receive(server::Connection::kBodyPiece) == server::Transport::Step::done) {
  }
  return std::string(connection.buffered());
}

std::string received(std::string_view sent, const server::Head& head, std::size_t longest, Dice& dice) {
  const Client client(sent, longest, dice);
  server::Connection connection(client.end());
  server::Body body(connection, head, kMostBytes);
  std::string bytes;
  std::optional<api::Problem> refusal;
  body.read(
      [&](std::string_view piece) {
        bytes += piece;
        return std::optional<api::Problem>();
      },
      [&](const server::Body::Refusal& why) { refusal = why; });
  const auto step = body.go_on();
  require(step != server::Transport::Step::wants_read, "a client that has closed is not waited for");
  if (step == server::Transport::Step::closed) body.stop(server::malformed("closed too soon"));
  require(body.bytes() == bytes.size() && bytes.size() <= kMostBytes, "a body is within its limit, and counted");
  require(body.consumed() == !refusal, "a body is consumed unless it is refused");
  require(head.chunked || refusal || bytes.size() == head.content_length, "a body is as long as its head says");
  if (!refusal) return bytes + "\nrest " + rest_of(connection);
  require_answer(*refusal);
  return bytes + "\nrefused " + refusal->detail;
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(body) {
  using namespace meshgauge::fuzz;
  if (size == 0 || size > kLongestInput) return 0;
  const auto sent = text_of(data, size).substr(1);
  meshgauge::server::Head head;
  head.chunked = *data == 'c';
  if (!head.chunked) head.content_length = *data;
  Dice dice = dice_of(sent);
  const std::string whole = received(sent, head, kLongestInput, dice);
  const std::size_t shortest = sent.size() / kMostPackets + 1;
  for (const std::size_t longest : {shortest, 4 * shortest}) {
    require(received(sent, head, longest, dice) == whole, "a body does not depend on how it is cut", whole);
  }
  return 0;
}
