// Sends requests to the service, with retries.
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

inline constexpr std::size_t kMostReplyBytes = std::size_t{4} << 20;  // maximum size of an answer

// Error of a gate that was cancelled before there was an interval.
Error cancelled();

// Thread safe.
class Client {
 public:
  // `base`: base_of() of the options' URL.
  Client(const RemoteOptions& options, const std::string& base);

  const std::string& base() const { return http_.settings().base; }
  bool has_key() const { return !http_.settings().key.empty(); }
  std::chrono::milliseconds retry_time() const { return retry_time_; }
  std::chrono::milliseconds cancel_time() const { return cancel_time_; }

  // Sends the request, again after transient failures. Returns the last reply: a success, a permanent refusal, or a
  // failure that outlasted `retry_time`. Errors: cancelled(), or why there is no reply. Calls `refused` for each 429
  // and 503. Blocks.
  Result<HttpAnswer> ask(const HttpRequest& request, Control& control, const std::function<void()>& refused = {});

  // Sends the request once.
  HttpAnswer once(const HttpRequest& request, const Interrupted& interrupted);

 private:
  std::optional<Error> known_trouble();
  Error no_reply(const HttpAnswer& answer);

  net::HttpClient http_;
  const std::chrono::milliseconds retry_time_;
  const std::chrono::milliseconds first_contact_;
  const std::chrono::milliseconds cancel_time_;
  std::atomic<bool> reached_{false};  // the service has answered at least once
  std::mutex mutex_;
  std::optional<Error> never_reached_;  // guarded by mutex_; spares the next gates the same waiting
};

}  // namespace meshgauge::check::service
