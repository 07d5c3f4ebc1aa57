// The header Idempotency-Key: a client's name for a request, under which it can be repeated safely.
#pragma once

#include <optional>
#include <string>

#include "api/problem.h"
#include "server/http/head.h"

namespace meshgauge::server {

// Sets `key` to the header's value, or leaves it when the header is missing. Returns a problem if the header is sent
// twice or is not 1 to 255 visible ASCII characters.
std::optional<api::Problem> read_idempotency_key(const Head& head, std::string& key);

}  // namespace meshgauge::server
