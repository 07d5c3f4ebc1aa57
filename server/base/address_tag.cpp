#include "server/base/address_tag.h"

#include <span>

#include "api/digest.h"

namespace meshgauge::server {

std::string address_tag(const std::string& address) {
  static const std::string key = api::random_id();
  const std::string keyed = key + address;
  return api::sha256_hex(std::as_bytes(std::span(keyed))).substr(0, 32);
}

}  // namespace meshgauge::server
