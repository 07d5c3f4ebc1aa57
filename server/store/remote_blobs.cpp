#include "server/store/remote_blobs.h"

#include "api/base/digest.h"

namespace meshgauge::server::store {

bool is_blob_id(const std::string& id) {
  return id.size() == 64 && id.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string blob_name(const BlobKey& key) {
  const std::string owner = api::sha256_hex(std::as_bytes(std::span(key.owner)));
  return owner + "/" + key.id.substr(0, 2) + "/" + key.id;
}

}  // namespace meshgauge::server::store
