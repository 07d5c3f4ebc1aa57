// The header Prefer (RFC 7240): Prefer: respond-async, wait=10
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/http/head.h"

namespace meshgauge::server {

struct Preferences {
  // Time that the client waits for the result before it gets a 202; nullopt: until the result is there.
  std::optional<std::chrono::milliseconds> wait;
  std::string applied;  // value for Preference-Applied; empty: no preference was sent
};

// Unknown and malformed preferences are ignored, as the RFC demands. Of two with the same name the first counts. `wait`
// is capped at one hour.
Preferences preferences(const Head& head);

}  // namespace meshgauge::server
