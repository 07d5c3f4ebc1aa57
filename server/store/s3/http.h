// One exchange over HTTP after another, over connections that are kept open and shared by all threads.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/store/byte_source.h"
#include "server/store/s3/signature.h"

namespace meshgauge::server::store {

struct HttpLimits {
  std::chrono::milliseconds connect{5'000};
  std::chrono::seconds stall{30};     // without a byte, in either direction
  std::chrono::seconds small{60};     // of an exchange without a large body
  std::chrono::seconds patient{600};  // of one that the server may think about for minutes, without a byte
};

enum class HttpPace { small, body, patient };

struct HttpRequest {
  std::string method;
  std::string url;
  NamedTexts headers;
  ByteSource body;
  HttpPace pace = HttpPace::small;
  // Is given the body of an answer 200 or 206, piece by piece; an error ends the exchange. Empty: it is the answer's
  // text, as any other body is.
  std::function<Result<Done>(long status, std::span<const std::byte> piece)> take;
};

struct HttpAnswer {
  long status = 0;               // 0: there is no whole answer
  std::string trouble;           // why not
  bool may_pass = false;         // ... and whether it is worth trying again
  std::optional<Error> stopped;  // what ended the exchange on our side: take(), or the body that could not be read
  std::map<std::string, std::string> headers;  // names in lower case
  std::string text;                            // at most kMaxText, more is trouble

  static constexpr std::size_t kMaxText = std::size_t{8} << 20;
  std::string header(const std::string& name) const;  // "" when there is none
};

// Thread safe. An exchange has a connection to itself; those that are done wait for the next one. Nothing is followed
// (no redirection) and nothing is unpacked.
class HttpConnections {
 public:
  HttpConnections(std::string ca_file, HttpLimits limits);
  ~HttpConnections();
  HttpConnections(const HttpConnections&) = delete;
  HttpConnections& operator=(const HttpConnections&) = delete;

  HttpAnswer perform(const HttpRequest& request);

 private:
  struct Freed {
    void operator()(void* easy) const;
  };
  using Easy = std::unique_ptr<void, Freed>;  // libcurl's CURL, which keeps its connection between exchanges

  Easy take_idle();
  void give_back(Easy easy);
  void prepare(void* easy, const HttpRequest& request) const;

  const std::string ca_file_;
  const HttpLimits limits_;
  std::mutex mutex_;
  std::vector<Easy> idle_;
};

}  // namespace meshgauge::server::store
