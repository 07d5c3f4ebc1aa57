// A connection string of PostgreSQL (libpq): "host=a,b dbname=x", or postgresql://user@a,b/x.
#pragma once

#include <string>

namespace meshgauge::server::store {

bool is_conninfo(const std::string& text);

// Returns the string without the values that libpq marks as secret, for logs: `text` itself when it has none, "" when
// it is no connection string.
std::string without_password(const std::string& text);

}  // namespace meshgauge::server::store
