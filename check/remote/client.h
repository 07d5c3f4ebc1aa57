// The service, asked as often as it takes: connections that are shared by all gates, and retries.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "check/remote.h"
#include "check/remote/connection.h"
#include "check/remote/exchange.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// The error of a gate that was cancelled before there was an interval.
Error cancelled();

// Thread safe.
class Client {
 public:
  // `base`: base_of() the options' URL.
  Client(const RemoteOptions& options, const std::string& base);

  const std::string& base() const { return access_.base; }
  bool has_key() const { return !access_.key.empty(); }
  std::chrono::milliseconds patience() const { return patience_; }

  // The last reply: a success, what is not tried again, or what has not passed for as long as patience lasts. An Error
  // is cancelled(), or says why there is no reply. `refused` is told of each 429 and 503.
  Result<Reply> ask(const Call& call, Control& control, const std::function<void()>& refused = {});

  // One try.
  Exchange once(const Call& call, const Interrupted& interrupted);

 private:
  std::unique_ptr<Connection> take();
  void give_back(std::unique_ptr<Connection> connection);
  std::optional<Error> known_trouble();
  Error no_reply(const Exchange& exchange);

  const Access access_;
  const std::chrono::milliseconds patience_;
  const std::chrono::milliseconds first_contact_;
  std::atomic<bool> reached_{false};               // something has answered
  std::mutex mutex_;                               // guards what follows
  std::vector<std::unique_ptr<Connection>> idle_;  // the last one used at the end
  std::optional<Error> never_reached_;             // so the next gates need not try for as long
};

}  // namespace meshgauge::check::service
