// The one HTTP client, by libcurl: the front end's and the workers' for S3, the gate's for a service.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::net {

struct HttpSettings {
  std::string base;            // scheme, host and port, in front of each request's path
  std::string key;             // a bearer token; empty: none
  std::string user_agent;      // empty: none
  std::string ca_file;         // trusted instead of this machine's certificates; empty: those
  bool without_proxy = false;  // else as the environment says
  // A status of 400 or more is an answer although the connection broke while the body was sent.
  bool early_refusals = false;
  std::chrono::milliseconds connect{10'000};
  std::chrono::seconds stall{30};       // that long slower than `least_speed` ends an exchange
  long least_speed = 1;                 // bytes a second, in either direction
  std::size_t most_body = 4ULL << 20U;  // bytes held of an answer; more is Trouble::hopeless
};

// The bytes that a request sends, read by offset. Refers to what outlives the exchange.
struct HttpBody {
  HttpBody() = default;
  HttpBody(std::span<const std::byte> bytes);  // NOLINT(google-explicit-constructor)
  template <class Read>
  HttpBody(std::uint64_t its_size, Read its_read) : size(its_size), read(std::move(its_read)) {}

  std::uint64_t size = 0;
  // Fills `into` from the offset on, as far as there are bytes; returns how many. An Error ends the exchange.
  std::function<Result<std::size_t>(std::uint64_t offset, std::span<std::byte> into)> read;
};

struct HttpRequest {
  std::string method;  // "HEAD", "GET", "PUT", "POST" or "DELETE"
  std::string path;    // encoded, sent as it is
  // An empty value takes back a header of libcurl's own.
  std::vector<std::pair<std::string, std::string>> headers;
  HttpBody body = {};                       // of PUT and POST
  std::chrono::milliseconds limit{60'000};  // of the whole exchange; 0: none
  bool may_stall = false;                   // the server may think for minutes without a byte
  std::function<void()> begin = nullptr;    // called before each exchange
  // Takes the body of an answer 200 or 206, piece by piece; an Error ends the exchange. Null: it is the answer's body.
  std::function<Result<Done>(int status, std::span<const std::byte> piece)> take = nullptr;
};

// Why there is no whole answer.
enum class Trouble {
  none,
  no_contact,  // nothing listens there; may pass
  broken,      // the connection was lost or stalled; may pass
  hopeless,    // an untrusted certificate, an answer that is not HTTP or too large, an Error of take() or the body
  cancelled,   // interrupted
};

struct HttpAnswer {
  Trouble trouble = Trouble::none;
  std::string why;                             // for people; of a trouble
  std::optional<Error> stopped;                // of take() or the body
  int status = 0;                              // 0: there is a trouble
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
  std::optional<std::chrono::seconds> retry_after;
  std::string redirect;  // where a redirection points

  std::string header(const std::string& name) const;  // "" when there is none
  bool may_pass() const { return trouble == Trouble::no_contact || trouble == Trouble::broken; }
};

// Thread safe. An exchange has a connection to itself; connections that are idle are kept for the next ones. Follows no
// redirection: a key or a signature goes to the address that was given, and nowhere else. Unpacks nothing.
class HttpClient {
 public:
  explicit HttpClient(HttpSettings settings);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  const HttpSettings& settings() const { return settings_; }

  // Blocks until the exchange ends, or soon after `interrupted` says so, which is asked every 10 ms.
  HttpAnswer perform(const HttpRequest& request, const Interrupted& interrupted = never_interrupted);

 private:
  struct Connection;

  std::unique_ptr<Connection> take_idle();
  void give_back(std::unique_ptr<Connection> connection);

  const HttpSettings settings_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Connection>> idle_;  // the last one used at the end
};

}  // namespace meshgauge::net
