// Which certificates this machine trusts.
#pragma once

#include <string>

namespace meshgauge::net {

// Returns the file that the variable SSL_CERT_FILE names, else the distribution's file of certificates; libcurl knows
// the place of one distribution alone. Empty: none of the known places has one.
std::string machine_certificates();

}  // namespace meshgauge::net
