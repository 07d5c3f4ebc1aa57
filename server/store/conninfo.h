// A connection string of PostgreSQL (libpq): "host=a,b dbname=x", or postgresql://user@a,b/x.
#pragma once

#include <string>

namespace meshgauge::server::store {

bool is_conninfo(const std::string& text);

// The same without what libpq marks as secret, for eyes and logs: `text` itself when there is nothing to hide, "" when
// it is no connection string.
std::string without_password(const std::string& text);

}  // namespace meshgauge::server::store
