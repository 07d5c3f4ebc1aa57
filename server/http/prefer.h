// What a client prefers (RFC 7240): Prefer: respond-async, wait=10.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "server/http/head.h"

namespace meshgauge::server {

struct Preferences {
  // How long the client wants to wait for the result before it is told where to ask for it; nullopt: until it is there.
  std::optional<std::chrono::milliseconds> wait;
  std::string applied;  // the value of Preference-Applied; empty: nothing was asked for
};

// Preferences that are not known here, or not understood, are ignored, as the RFC asks. Of two of a kind the first
// counts.
Preferences preferences(const Head& head);

}  // namespace meshgauge::server
