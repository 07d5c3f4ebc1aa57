// The stores that several machines share: jobs, results and meshes' rows in PostgreSQL; blobs in S3 or in PostgreSQL,
// with a cache of files on each machine.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "server/store/cached_blobs.h"
#include "server/store/data_folder.h"
#include "server/store/forms/stores.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {

// The settings of the same names (server/settings/settings.h).
struct DistributedSettings {
  std::string database;
  std::string blobs;  // "": in the database; or s3://BUCKET/PREFIX
  std::string s3_endpoint;
  std::string s3_region = "us-east-1";
  bool s3_virtual_host = false;
  std::uint64_t blob_cache_bytes = std::uint64_t{10} << 30;
  std::string data_folder;  // of this process alone; holds cache/
  std::size_t max_unrecorded = 10'000;
  std::size_t max_connections = 8;
  std::chrono::milliseconds call_timeout{4000};  // as in PostgresSettings
  std::chrono::milliseconds duty_grace{15'000};  // as in PostgresSettings
  Report report = {};                            // gets lines about outages of the database and of S3
};

class DistributedStores final : public AllStores {
 public:
  static Result<std::unique_ptr<DistributedStores>> open(const DistributedSettings& settings);

  JobStore& jobs() override { return *store_; }
  MeshIndex& meshes() override { return *store_; }
  BatchStore& batches() override { return *store_; }
  Listings& listings() override { return *store_; }
  BlobStore& blobs() override { return *blobs_; }
  Signals& signals() override { return store_->signals(); }
  bool shared() const override { return true; }
  const std::string& data_folder() const override { return folder_.path(); }

  const CachedBlobs& cached_blobs() const { return *blobs_; }

 private:
  explicit DistributedStores(DataFolder folder) : folder_(std::move(folder)) {}

  DataFolder folder_;  // holds the lock, so it is destroyed last
  std::unique_ptr<PostgresStore> store_;
  std::unique_ptr<CachedBlobs> blobs_;  // may use the store's connections
};

}  // namespace meshgauge::server::store
