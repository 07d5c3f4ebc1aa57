#include "server/http/tls.h"

#include <fcntl.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>
#include <new>
#include <utility>

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include "api/base/refused.h"

namespace meshgauge::server {
namespace {

// Cipher suites of TLS 1.2 with forward secrecy and authenticated encryption. All suites of TLS 1.3 have both.
constexpr const char* kCiphers = "ECDHE+AESGCM:ECDHE+CHACHA20";

// Groups of the key exchange, the cheapest first. OpenSSL has those of RFC 7919 as well: one hello with a share of
// 8192 bits would cost as much as twenty others.
constexpr const char* kGroups = "X25519:P-256:P-384:P-521";
// Below TLS 1.3 the secret is derived when the client's share has come, on the loop: of the others it takes 0.5 ms.
constexpr const char* kQuickGroups = "X25519:P-256";

constexpr int kOfTransport = 0;  // index of the data that OpenSSL leaves to an application

class TlsTransport final : public Transport {
 public:
  TlsTransport(SSL_CTX* context, int fd) : fd_(fd), ssl_(SSL_new(context)) {
    // OpenSSL's own reading and writing of a socket has no MSG_DONTWAIT. It has no MSG_NOSIGNAL either; the HTTP
    // library ignores SIGPIPE for the whole process.
    const int flags = ::fcntl(fd, F_GETFL);
    const bool quick = flags >= 0 && ::fcntl(fd, F_SETFL, flags | O_NONBLOCK) == 0;
    if (!quick || !ssl_ || SSL_set_fd(ssl_.get(), fd) != 1) throw std::bad_alloc();
    if (SSL_set_ex_data(ssl_.get(), kOfTransport, this) != 1) throw std::bad_alloc();
    SSL_set_accept_state(ssl_.get());
  }

  // OpenSSL's callback: holds each hello back before anything is computed for it, until handshake() is called again. A
  // client that is asked for another key share sends a second one.
  static int hold_back(SSL* ssl, int*, void*) {
    auto* const transport = static_cast<TlsTransport*>(SSL_get_ex_data(ssl, kOfTransport));
    return std::exchange(transport->may_compute_, false) ? SSL_CLIENT_HELLO_SUCCESS : SSL_CLIENT_HELLO_RETRY;
  }

  Step handshake() override {
    ERR_clear_error();
    const int result = SSL_do_handshake(ssl_.get());
    return result == 1 ? Step::done : step_of(result);
  }

  // Reads several records: one has 16 KiB at most. Stops at an update of keys, also where bytes have come before it.
  Moved read(char* out, std::size_t size) override {
    ERR_clear_error();
    std::size_t total = 0;
    Step step = Step::done;
    while (total < size && step == Step::done) {
      std::size_t n = 0;
      const int result = SSL_read_ex(ssl_.get(), out + total, size - total, &n);
      total += n;
      if (result != 1) step = step_of(result);
    }
    return {total > 0 ? Step::done : step, total};
  }

  Moved write(std::string_view bytes) override {
    ERR_clear_error();
    std::size_t n = 0;
    const int result = SSL_write_ex(ssl_.get(), bytes.data(), bytes.size(), &n);
    if (result == 1) return {Step::done, n};
    return {step_of(result), 0};
  }

  Moved discard(std::size_t most) override {
    std::array<char, std::size_t{16} << 10> bytes;
    return read(bytes.data(), std::min(most, bytes.size()));
  }

  // A peer may send close_notify without closing its socket, so the next record is looked at as well.
  bool peer_gone() override {
    if (peer_hung_up(fd_)) return true;
    ERR_clear_error();
    char byte = 0;
    const int result = SSL_peek(ssl_.get(), &byte, 1);
    return result <= 0 && step_of(result) == Step::closed;
  }

  void end() override {
    ERR_clear_error();
    if (!broken_ && SSL_is_init_finished(ssl_.get()) == 1) SSL_shutdown(ssl_.get());
    ::shutdown(fd_, SHUT_WR);
  }

 private:
  struct Freed {
    void operator()(SSL* ssl) const { SSL_free(ssl); }
  };

  Step step_of(int result) {
    switch (SSL_get_error(ssl_.get(), result)) {
      case SSL_ERROR_WANT_READ:
        return Step::wants_read;
      case SSL_ERROR_WANT_WRITE:
        return Step::wants_write;
      case SSL_ERROR_WANT_CLIENT_HELLO_CB:
        may_compute_ = true;
        return Step::wants_thread;
      case SSL_ERROR_ZERO_RETURN:
        return Step::closed;
      default:
        broken_ = true;  // after a fatal error SSL_shutdown() must not be called
        return Step::closed;
    }
  }

  const int fd_;
  std::unique_ptr<SSL, Freed> ssl_;
  bool may_compute_ = false;  // for the hello that is held back
  bool broken_ = false;
};

Error file_error(const char* flag, const std::string& file) {
  const unsigned long code = ERR_peek_error();
  const char* reason = ERR_SYSTEM_ERROR(code) ? std::strerror(ERR_GET_REASON(code)) : ERR_reason_error_string(code);
  return refused(std::string(flag) + " '" + file + "' cannot be used: " + (reason ? reason : "it is not a PEM file"));
}

// Rejects a client whose ALPN list lacks http/1.1: it would not understand the response.
int select_protocol(SSL*, const unsigned char** out, unsigned char* out_size, const unsigned char* offered,
                    unsigned int offered_size, void*) {
  static constexpr unsigned char kHttp[] = "\x08http/1.1";
  unsigned char* chosen = nullptr;
  const int selected = SSL_select_next_proto(&chosen, out_size, kHttp, sizeof kHttp - 1, offered, offered_size);
  *out = chosen;
  return selected == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
}

// OpenSSL calls it when the version is chosen and the group is not.
int limit_groups(SSL* ssl, void*) {
  return SSL_version(ssl) >= TLS1_3_VERSION || SSL_set1_groups_list(ssl, kQuickGroups) == 1 ? 1 : 0;
}

int no_passphrase(char*, int, int, void*) { return -1; }  // else OpenSSL asks for one on the terminal

bool configure(SSL_CTX* context) {
  SSL_CTX_set_options(context, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE |
                                   SSL_OP_PRIORITIZE_CHACHA);
  SSL_CTX_set_mode(context,
                   SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER | SSL_MODE_RELEASE_BUFFERS);
  // Else one call of SSL_read() would take all updates of keys that have arrived, each some microseconds.
  SSL_CTX_clear_mode(context, SSL_MODE_AUTO_RETRY);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);  // sessions are resumed by the clients' tickets
  SSL_CTX_set_default_passwd_cb(context, no_passphrase);
  SSL_CTX_set_alpn_select_cb(context, select_protocol, nullptr);
  SSL_CTX_set_client_hello_cb(context, TlsTransport::hold_back, nullptr);
  SSL_CTX_set_cert_cb(context, limit_groups, nullptr);
  return SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION) == 1 &&
         SSL_CTX_set_cipher_list(context, kCiphers) == 1 && SSL_CTX_set1_groups_list(context, kGroups) == 1;
}

std::string end_of(SSL_CTX* context) {
  const std::unique_ptr<BIO, int (*)(BIO*)> text(BIO_new(BIO_s_mem()), BIO_free);
  if (!text || ASN1_TIME_print(text.get(), X509_get0_notAfter(SSL_CTX_get0_certificate(context))) != 1) return "?";
  char* data = nullptr;
  const auto size = BIO_get_mem_data(text.get(), &data);
  return {data, static_cast<std::size_t>(size)};
}

}  // namespace

Tls::Tls(std::string certificate, std::string key) : certificate_(std::move(certificate)), key_(std::move(key)) {}

Result<std::string> Tls::reload() {
  ERR_clear_error();
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context || !configure(context.get())) return Error{ErrorCode::internal, "OpenSSL refuses TLS 1.2", "", ""};
  if (SSL_CTX_use_certificate_chain_file(context.get(), certificate_.c_str()) != 1) {
    return file_error("--tls-certificate", certificate_);
  }
  if (SSL_CTX_use_PrivateKey_file(context.get(), key_.c_str(), SSL_FILETYPE_PEM) != 1) {
    return file_error("--tls-key", key_);
  }
  const std::lock_guard lock(mutex_);
  context_ = context;
  return end_of(context.get());
}

std::unique_ptr<Transport> Tls::accept(int fd) const {
  std::shared_ptr<SSL_CTX> context;
  {
    const std::lock_guard lock(mutex_);
    context = context_;
  }
  assert(context);
  return std::make_unique<TlsTransport>(context.get(), fd);  // the session keeps a reference to the context
}

}  // namespace meshgauge::server
