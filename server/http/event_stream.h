// Formats server-sent events (text/event-stream) and chunks (RFC 9112 section 7.1).
#pragma once

#include <string>
#include <string_view>

namespace meshgauge::server {

// Returns one event as text. Precondition: `data` is one line.
std::string event(std::string_view name, std::string_view data);

std::string chunk(std::string_view piece);  // precondition: not empty, since an empty chunk ends a body

}  // namespace meshgauge::server
