#include "server/store/remote_blobs.h"

#include "api/base/digest.h"
#include "api/base/text.h"

namespace meshgauge::server::store {

bool is_blob_id(const std::string& id) { return api::is_lower_hex(id, 64); }

std::string blob_name(const BlobKey& key) {
  const std::string owner = api::sha256_hex(std::as_bytes(std::span(key.owner)));
  return owner + "/" + key.id.substr(0, 2) + "/" + key.id;
}

}  // namespace meshgauge::server::store
