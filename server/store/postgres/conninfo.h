// Connection strings of PostgreSQL, in both forms: "host=a,b dbname=x" and "postgresql://a,b/x".
#pragma once

#include <string>

namespace meshgauge::server::store {

// The same as name=value pairs, with passwords hidden: to be shown. Of one that cannot be understood nothing is shown.
std::string without_password(const std::string& database);

}  // namespace meshgauge::server::store
