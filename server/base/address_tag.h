// Names a client by its address without keeping the address.
#pragma once

#include <string>

namespace meshgauge::server {

// Returns a digest of the address, under a key that this process draws at its start and keeps to itself: it is the same
// for as long as the process runs, and does not tell the address. Thread safe.
std::string address_tag(const std::string& address);

}  // namespace meshgauge::server
