// The one HTTP client, by libcurl: for S3, and for gates at a service.
#pragma once

#include <chrono>
#include <cstddef>
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
  std::string base;            // scheme, host and port, before each request's path
  std::string key;             // a bearer token; empty: none
  std::string user_agent;      // empty: none
  std::string ca_file;         // certificates trusted instead of this machine's; empty: machine_certificates()
  bool without_proxy = false;  // false: proxies of the environment
  // A status of 400 or more counts as the answer even if the connection broke while the body was sent.
  bool early_refusals = false;
  std::chrono::milliseconds connect{10'000};
  std::chrono::seconds stall{30};  // an exchange slower than `least_speed` for so long fails
  long least_speed = 1;            // bytes per second, in either direction
  // Maximum size of an answer that is stored; beyond it Trouble::hopeless, at once where its head says so.
  std::size_t most_body = 4ULL << 20U;
};

struct HttpRequest {
  std::string method;  // "HEAD", "GET", "PUT", "POST" or "DELETE"
  std::string path;    // percent-encoded; sent as it is
  // An empty value removes libcurl's own header of that name.
  std::vector<std::pair<std::string, std::string>> headers;
  std::span<const std::byte> body = {};     // for PUT and POST; outlives the exchange
  std::chrono::milliseconds limit{60'000};  // time limit of the whole exchange; 0: none
  std::chrono::seconds stall{0};            // as that of the settings, where it is less; 0: theirs alone
  bool may_stall = false;                   // the server may take minutes without sending a byte
  std::function<void()> begin = nullptr;    // called before each exchange
  // Receives the body of a 200 or 206 piece by piece; an Error ends the exchange. Null: the body is stored in the
  // answer.
  std::function<Result<Done>(int status, std::span<const std::byte> piece)> take = nullptr;
};

// Returns the file of certificates that this machine trusts: the one that the variable SSL_CERT_FILE names, else the
// distribution's; libcurl knows the place of one distribution alone. Empty: none of the known places has one.
std::string machine_certificates();

// Why there is no complete answer.
enum class Trouble {
  none,
  no_contact,  // no connection; transient
  broken,      // the connection was lost or stalled; transient
  hopeless,    // permanent: an untrusted certificate, an answer that is not HTTP or too large, an Error of take() or of
               // the body
  cancelled,   // interrupted
};

struct HttpAnswer {
  Trouble trouble = Trouble::none;
  std::string why;                             // explanation of a trouble, for people
  std::optional<Error> stopped;                // the Error of take() or of the body
  int status = 0;                              // 0: there is a trouble
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
  std::optional<std::chrono::seconds> retry_after;
  std::string redirect;  // target of a redirection

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
