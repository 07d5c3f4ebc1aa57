// One request to the service and what came of it.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::check::service {

// Takes the body of a success as it comes, where it may be longer than what is held of an answer.
class Sink {
 public:
  virtual ~Sink() = default;
  virtual void begin() = 0;                       // of each try
  virtual bool take(std::string_view piece) = 0;  // false: it cannot be what was asked for, and the exchange ends
};

struct Call {
  std::string method;                       // "HEAD", "GET", "PUT", "POST" or "DELETE"
  std::string path;                         // "/v1/..."
  std::vector<std::string> headers;         // "Name: value"
  std::span<const std::byte> body;          // borrowed, and sent from where it is
  std::chrono::milliseconds limit{60'000};  // of the whole exchange
  Sink* sink = nullptr;                     // borrowed; may be null
};

struct Reply {
  int status = 0;
  std::string body;
  std::string content_type;
  std::optional<std::chrono::seconds> retry_after;
  std::string redirect;  // where a redirection points; none is followed
};

// Why there is no reply.
enum class Trouble {
  none,
  no_contact,  // nobody answers there; may pass
  broken,      // the connection was lost or stalled; may pass
  hopeless,    // a certificate that is not trusted, an answer that is not HTTP or too large
  cancelled,
};

struct Exchange {
  Trouble trouble = Trouble::none;
  std::string why;  // for people; of a trouble
  Reply reply;      // without a trouble
};

}  // namespace meshgauge::check::service
