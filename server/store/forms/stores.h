// All stores of a service, in one of two forms: on this machine (embedded), or in databases that several machines share
// (distributed).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "server/store/batch_store.h"
#include "server/store/blob_store.h"
#include "server/store/data_folder.h"
#include "server/store/job_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/outage.h"
#include "server/store/postgres/postgres_store.h"
#include "server/store/reserve.h"
#include "server/store/signals.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {

// The form on this machine: a folder with a database and files.
struct EmbeddedSettings {
  std::string data_folder;
  std::size_t max_unrecorded = 10'000;  // records that are held while they cannot be written
  Report report = {};                   // gets a line when an older schema was migrated
};

// The form that several machines share: jobs, results and meshes' rows in PostgreSQL; blobs in S3 or in PostgreSQL,
// with a cache of files on each machine. The settings of the same names (server/settings/settings.h).
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

// The stores of a process, in one of both forms.
class AllStores {
 public:
  static Result<std::unique_ptr<AllStores>> open_embedded(const EmbeddedSettings& settings);
  static Result<std::unique_ptr<AllStores>> open_distributed(const DistributedSettings& settings);

  JobStore& jobs() { return *database_; }
  MeshIndex& meshes() { return *database_; }
  BatchStore& batches() { return *database_; }
  Listings& listings() { return *database_; }
  BlobStore& blobs() { return *blobs_; }
  Signals& signals() { return database_->signals(); }
  bool shared() const { return shared_; }  // other processes use these stores, too
  const std::string& data_folder() const { return folder_.path(); }

 private:
  AllStores(DataFolder folder, bool shared)
      : shared_(shared), folder_(std::move(folder)), reserve_(folder_.path() + "/reserve") {}

  const bool shared_;
  DataFolder folder_;  // holds the lock, so it is destroyed last
  Reserve reserve_;    // of the embedded form
  std::unique_ptr<Database> database_;
  std::unique_ptr<BlobStore> blobs_;  // may use the database's connections
};

}  // namespace meshgauge::server::store
