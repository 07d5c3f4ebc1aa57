// Sends requests to the service, with retries: which failures are retried, how often and after which pause.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>

#include "check/remote.h"
#include "engine/control.h"
#include "engine/result.h"
#include "net/http_client.h"

namespace meshgauge::check::service {

using net::HttpAnswer;
using net::HttpRequest;
using net::Trouble;

inline constexpr std::size_t kMostReplyBytes = std::size_t{4} << 20;  // maximum size of an answer

struct RetriedStatus {
  int status;
  int tries;  // maximum number of tries; 0: until `retry_time` is over
};

// Statuses of transient failures. Every request may be repeated: meshes are named by their bytes, batches by an
// Idempotency-Key.
std::span<const RetriedStatus> retried_statuses();

// The retries of one call. The pause doubles from try to try and is drawn from its upper half, so that clients that
// were refused together do not return together. It is never shorter than the service's Retry-After.
class Retries {
 public:
  using Clock = std::chrono::steady_clock;
  using Milliseconds = std::chrono::milliseconds;

  static constexpr Milliseconds kFirst{200};
  static constexpr Milliseconds kMost{15'000};

  // Both times count from the first failure.
  Retries(Milliseconds retry_time, Milliseconds first_contact)
      : retry_time_(retry_time), first_contact_(first_contact) {}

  // Returns the pause before the next try, or nullopt after the last one. `reached`: the service has answered before.
  // `random`: from 0 to 1.
  std::optional<Milliseconds> after(const net::HttpAnswer& failed, bool reached, Clock::time_point now, double random);

 private:
  const Milliseconds retry_time_;
  const Milliseconds first_contact_;
  std::optional<Clock::time_point> since_;
  int tries_ = 0;
};

// Returns an Interrupted that is true once `time` has passed from now.
inline Interrupted after(std::chrono::milliseconds time) {
  return [end = Control::Clock::now() + time] { return Control::Clock::now() >= end; };
}

// Sleeps for `time`. False: cancelled.
inline bool pause(std::chrono::milliseconds time, Control& control) {
  constexpr std::chrono::milliseconds kTick{10};
  const Interrupted over = after(time);
  while (control.check() != Interruption::cancelled) {
    if (over()) return true;
    std::this_thread::sleep_for(kTick);
  }
  return false;
}

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
  // How long all tries of a request may take for gates of this `timeout`.
  std::chrono::milliseconds patience(std::chrono::milliseconds timeout) const {
    return std::max(timeout, least_patience_);
  }
  std::chrono::milliseconds cancel_time() const { return cancel_time_; }

  // Sends the request, again after transient failures. Returns the last reply: a success, a permanent refusal, or a
  // failure that outlasted `retry_time`. Errors: cancelled(), or why there is no reply. Blocks for patience(timeout) at
  // most; where much is sent or received, so long after a first failure. `timeout`: of the gates that it is for.
  Result<HttpAnswer> ask(const HttpRequest& request, Control& control, std::chrono::milliseconds timeout);

  // Sends the request once.
  HttpAnswer once(const HttpRequest& request, const Interrupted& interrupted);

 private:
  std::optional<Error> known_trouble();
  Error no_reply(const HttpAnswer& answer);

  net::HttpClient http_;
  const std::chrono::milliseconds retry_time_;
  const std::chrono::milliseconds first_contact_;
  const std::chrono::milliseconds least_patience_;
  const std::chrono::milliseconds cancel_time_;
  std::atomic<bool> reached_{false};  // the service has answered at least once
  std::mutex mutex_;
  std::optional<Error> never_reached_;  // guarded by mutex_; spares the next gates the same waiting
};

}  // namespace meshgauge::check::service
