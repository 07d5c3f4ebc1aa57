// TLS over a pair of sockets, with a client of OpenSSL's: what is computed when.
#include "server/http/tls.h"

#include <sys/socket.h>

#include <array>
#include <memory>

#include <openssl/ssl.h>

#include <doctest/doctest.h>

#include "api/base/descriptor.h"
#include "tests/server/http/certificate_files.h"

namespace {

using meshgauge::Descriptor;
using meshgauge::server::CertificateFiles;
using meshgauge::server::Tls;
using meshgauge::server::Transport;
using TlsStep = meshgauge::server::Transport::Step;

// A connection of a client to a server, both in this thread; nothing blocks.
class TlsPair {
 public:
  // `groups`: of the client's key exchange, "" for OpenSSL's own.
  TlsPair(const Tls& tls, const char* groups, SSL_SESSION* session)
      : context_(SSL_CTX_new(TLS_client_method()), SSL_CTX_free), client_(nullptr, SSL_free) {
    int ends[2] = {-1, -1};
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends) == 0);
    ours_ = Descriptor(ends[0]);
    theirs_ = Descriptor(ends[1]);
    server_ = tls.accept(ours_.get());
    client_.reset(SSL_new(context_.get()));
    REQUIRE(SSL_set_fd(client_.get(), theirs_.get()) == 1);
    SSL_set_connect_state(client_.get());
    if (*groups != '\0') REQUIRE(SSL_set1_groups_list(client_.get(), groups) == 1);
    if (session != nullptr) REQUIRE(SSL_set_session(client_.get(), session) == 1);
  }

  Transport& server() { return *server_; }
  SSL* client() { return client_.get(); }

  // Whether the server has sent something that the client has not read.
  bool has_sent() const {
    char byte = 0;
    return ::recv(theirs_.get(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 1;
  }

  // From the client's hello to the end of both handshakes. Returns how often the server asked for a thread.
  int shake_hands() {
    int threads = 0;
    bool done = false;
    for (int i = 0; i < 10 && !done; ++i) {
      const bool client_done = SSL_do_handshake(client_.get()) == 1;
      const TlsStep step = server_->handshake();
      threads += step == TlsStep::wants_thread ? 1 : 0;
      REQUIRE(step != TlsStep::closed);
      done = client_done && step == TlsStep::done;
    }
    REQUIRE(done);
    return threads;
  }

 private:
  const std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)> context_;
  Descriptor ours_, theirs_;
  std::unique_ptr<SSL, decltype(&SSL_free)> client_;
  std::unique_ptr<Transport> server_;
};

}  // namespace

TEST_CASE("tls: nothing is computed for a hello before a thread takes it") {
  const CertificateFiles files;
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  TlsPair pair(tls, "", nullptr);
  CHECK(pair.server().handshake() == TlsStep::wants_read);
  CHECK(SSL_do_handshake(pair.client()) != 1);
  CHECK(pair.server().handshake() == TlsStep::wants_thread);
  CHECK_FALSE(pair.has_sent());
  CHECK(pair.server().handshake() == TlsStep::wants_read);
  CHECK(pair.has_sent());
  CHECK(SSL_do_handshake(pair.client()) == 1);
  CHECK(pair.server().handshake() == TlsStep::done);
}

TEST_CASE("tls: a client that is asked for another key share waits for a thread twice") {
  const CertificateFiles files;
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  CHECK(TlsPair(tls, "P-256", nullptr).shake_hands() == 1);
  CHECK(TlsPair(tls, "ffdhe2048:P-256", nullptr).shake_hands() == 2);  // the first one costs too much
}

TEST_CASE("tls: below TLS 1.3 the loop derives no secret of a group that costs much") {
  const CertificateFiles files("P-384");
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  const auto pair_of = [&](const char* groups, int version) {
    auto pair = std::make_unique<TlsPair>(tls, groups, nullptr);
    REQUIRE(SSL_set_max_proto_version(pair->client(), version) == 1);
    return pair;
  };
  CHECK(pair_of("P-384", TLS1_3_VERSION)->shake_hands() == 1);
  CHECK(pair_of("P-384:P-256", TLS1_2_VERSION)->shake_hands() == 1);
  const auto costly = pair_of("P-384", TLS1_2_VERSION);
  CHECK(SSL_do_handshake(costly->client()) != 1);
  CHECK(costly->server().handshake() == TlsStep::wants_thread);
  CHECK(costly->server().handshake() == TlsStep::closed);
}

TEST_CASE("tls: a session of TLS 1.3 is resumed by its ticket, and not after a reload") {
  const CertificateFiles files;
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  TlsPair first(tls, "", nullptr);
  first.shake_hands();
  CHECK(SSL_version(first.client()) == TLS1_3_VERSION);
  char byte = 0;
  CHECK(SSL_read(first.client(), &byte, 1) <= 0);  // takes the tickets
  const std::unique_ptr<SSL_SESSION, decltype(&SSL_SESSION_free)> session(SSL_get1_session(first.client()),
                                                                          SSL_SESSION_free);
  TlsPair second(tls, "", session.get());
  second.shake_hands();
  CHECK(SSL_session_reused(second.client()) == 1);
  REQUIRE(tls.reload().ok());
  TlsPair third(tls, "", session.get());
  third.shake_hands();
  CHECK(SSL_session_reused(third.client()) == 0);
}

TEST_CASE("tls: one call takes one update of the keys, however many have arrived") {
  constexpr int kUpdates = 50;
  const CertificateFiles files;
  Tls tls(files.certificate_file(), files.key_file());
  REQUIRE(tls.reload().ok());
  TlsPair pair(tls, "", nullptr);
  pair.shake_hands();
  for (int i = 0; i < kUpdates; ++i) {
    REQUIRE(SSL_key_update(pair.client(), SSL_KEY_UPDATE_NOT_REQUESTED) == 1);
    REQUIRE(SSL_do_handshake(pair.client()) == 1);
  }
  REQUIRE(SSL_write(pair.client(), "x", 1) == 1);
  std::array<char, 16> bytes{};
  int reads = 1;
  auto moved = pair.server().read(bytes.data(), bytes.size());
  for (; moved.step == TlsStep::wants_read && reads < 10 * kUpdates; ++reads) {
    moved = pair.server().read(bytes.data(), bytes.size());
  }
  CHECK(moved.step == TlsStep::done);
  CHECK(moved.bytes == 1);
  CHECK(bytes[0] == 'x');
  CHECK(reads == kUpdates + 1);
}
