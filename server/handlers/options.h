// POST /v1/options: reads the options of a comparison before any mesh is sent.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/problem.h"
#include "server/http/exchange.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Answers with the options as they are understood, written in one way, or with all mistakes.
void read_options(Exchange& exchange, const Settings& settings);

// Adds a piece of a JSON body of at most api::kMaxOptionsBytes.
std::optional<api::Problem> add_piece(std::string& text, std::string_view piece);

}  // namespace meshgauge::server
