// The service, asked as often as it takes.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <string>

#include "check/remote.h"
#include "engine/control.h"
#include "engine/result.h"
#include "net/http_client.h"

namespace meshgauge::check::service {

using net::HttpAnswer;
using net::HttpRequest;
using net::Trouble;

inline constexpr std::size_t kMostReplyBytes = std::size_t{4} << 20;  // held of an answer

// The error of a gate that was cancelled before there was an interval.
Error cancelled();

// Thread safe.
class Client {
 public:
  // `base`: base_of() the options' URL.
  Client(const RemoteOptions& options, const std::string& base);

  const std::string& base() const { return http_.settings().base; }
  bool has_key() const { return !http_.settings().key.empty(); }
  std::chrono::milliseconds patience() const { return patience_; }

  // The last reply: a success, what is not tried again, or what has not passed for as long as patience lasts. An Error
  // is cancelled(), or says why there is no reply. `refused` is told of each 429 and 503.
  Result<HttpAnswer> ask(const HttpRequest& request, Control& control, const std::function<void()>& refused = {});

  // One try.
  HttpAnswer once(const HttpRequest& request, const Interrupted& interrupted);

 private:
  std::optional<Error> known_trouble();
  Error no_reply(const HttpAnswer& answer);

  net::HttpClient http_;
  const std::chrono::milliseconds patience_;
  const std::chrono::milliseconds first_contact_;
  std::atomic<bool> reached_{false};  // something has answered
  std::mutex mutex_;
  std::optional<Error> never_reached_;  // guarded by it; so the next gates need not try for as long
};

}  // namespace meshgauge::check::service
