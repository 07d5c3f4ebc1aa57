// The stores of one machine: a folder with a database and files.
#pragma once

#include <memory>
#include <string>

#include "server/store/data_folder.h"
#include "server/store/file_blobs.h"
#include "server/store/forms/stores.h"
#include "server/store/outage.h"
#include "server/store/reserve.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {

struct EmbeddedSettings {
  std::string data_folder;
  std::size_t max_unrecorded = 10'000;  // records that are held while they cannot be written
  Report report = {};                   // gets a line when an older schema was migrated
};

class EmbeddedStores final : public AllStores {
 public:
  static Result<std::unique_ptr<EmbeddedStores>> open(const EmbeddedSettings& settings);

  JobStore& jobs() override { return *store_; }
  MeshIndex& meshes() override { return *store_; }
  BatchStore& batches() override { return *store_; }
  Listings& listings() override { return *store_; }
  BlobStore& blobs() override { return *blobs_; }
  Signals& signals() override { return store_->signals(); }
  bool shared() const override { return false; }
  const std::string& data_folder() const override { return folder_.path(); }

 private:
  explicit EmbeddedStores(DataFolder folder) : folder_(std::move(folder)), reserve_(folder_.path() + "/reserve") {}

  DataFolder folder_;  // holds the lock, so it is destroyed last
  Reserve reserve_;
  std::unique_ptr<FileBlobs> blobs_;
  std::unique_ptr<SqliteStore> store_;
};

}  // namespace meshgauge::server::store
