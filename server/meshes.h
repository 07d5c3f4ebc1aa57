// /v1/meshes: meshes that their owner stores once and compares often, under the SHA-256 of their bytes.
#pragma once

#include <optional>
#include <string>

#include "server/exchange.h"
#include "server/settings.h"
#include "server/store/mesh_index.h"
#include "server/upload.h"

namespace meshgauge::server {

class Meshes {
 public:
  // Borrows both.
  Meshes(const Settings& settings, store::MeshIndex& index, store::BlobStore& blobs);

  // Each may throw: out of memory. What is stored is not looked into: a comparison says what is wrong with it.
  void put(Exchange& exchange);
  void post(Exchange& exchange);
  void get(Exchange& exchange);
  void remove(Exchange& exchange);

 private:
  std::optional<api::Problem> receive(Exchange& exchange, std::uint64_t new_bytes, Upload& upload) const;
  std::optional<api::Problem> check_quota(const std::string& owner, std::uint64_t more) const;
  void keep(Exchange& exchange, const std::string& id, const Upload& upload);

  const Settings settings_;
  store::MeshIndex& index_;
  store::BlobStore& blobs_;
  ByteBudget budget_;
};

}  // namespace meshgauge::server
