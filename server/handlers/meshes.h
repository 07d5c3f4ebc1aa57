// Handlers of /v1/meshes: meshes that an owner stores once and compares often, named by the SHA-256 of their bytes.
#pragma once

#include <string>
#include <variant>

#include "api/result/json_of.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/http/upload.h"
#include "server/jobs/jobs.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

api::Json mesh_json(const store::MeshRow& row);

class Meshes {
 public:
  // Borrows all but the first. `uploads`: the byte budget of all uploads of the service.
  Meshes(const Settings& settings, const Stores& stores, Access& access, ByteBudget& uploads);

  // Each may throw: out of memory. Files are stored without being read; a comparison reports what is wrong with them.
  void put(Exchange& exchange);
  void post(Exchange& exchange);
  void get(Exchange& exchange);
  void remove(Exchange& exchange);

 private:
  void receive(Exchange& exchange, std::uint64_t new_bytes, const std::string& id);
  std::variant<StorageHold, Denial> hold_room(const std::string& owner, std::uint64_t more) const;
  void keep(Exchange& exchange, const std::string& id, const Upload& upload);
  void store(Exchange& exchange, const store::BlobKey& key, const Upload& upload);
  void discard(const store::BlobKey& key) const;

  const Settings settings_;
  const Stores stores_;
  Access& access_;
  ByteBudget& uploads_;
};

}  // namespace meshgauge::server
