// Idempotency-Key: what a client names a request by, so that it may send it again.
#pragma once

#include <optional>
#include <string>

#include "api/problem.h"
#include "server/http/head.h"

namespace meshgauge::server {

// Leaves `key` as it is when there is none.
std::optional<api::Problem> read_idempotency_key(const Head& head, std::string& key);

}  // namespace meshgauge::server
