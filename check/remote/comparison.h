// Measures one gate by a service: submits the comparison, follows it to its end, or cancels it.
#pragma once

#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "check/remote/adaptive_limit.h"
#include "check/remote/answer.h"
#include "check/remote/client.h"
#include "check/remote/pair.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Borrows all arguments.
class Comparison {
 public:
  // Precondition: no other gate of any run has `key`.
  Comparison(Client& client, AdaptiveLimit& limit, Pair& pair, std::string key, Control& control)
      : client_(client), limit_(limit), pair_(pair), key_(std::move(key)), control_(control) {}

  // Returns the JSON of the comparison. Blocks. Call once.
  Result<nlohmann::ordered_json> measure();

 private:
  using Clock = Control::Clock;

  Result<End> attempt();
  HttpRequest request(int wait) const;
  Result<End> answered(const HttpAnswer& reply);
  Result<End> follow(const std::string& id);
  bool take(Job job, End& end);
  Result<End> cancel(const std::string& id, const Interrupted& over);
  Result<End> abandon(const Error& why);
  bool again(const End& end);
  Error unexpected(const HttpAnswer& reply) const;

  Client& client_;
  AdaptiveLimit& limit_;
  Pair& pair_;
  const std::string key_;
  Control& control_;
  std::string document_;  // the request
  int attempts_ = 0;
  Progress progress_;
};

}  // namespace meshgauge::check::service
