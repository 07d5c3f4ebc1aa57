#include "server/store/forms/embedded.h"

namespace meshgauge::server::store {

Result<std::unique_ptr<EmbeddedStores>> EmbeddedStores::open(const EmbeddedSettings& settings) {
  Result<DataFolder> folder = DataFolder::open(settings.data_folder);
  if (!folder) return folder.error();
  std::unique_ptr<EmbeddedStores> stores(new EmbeddedStores(std::move(*folder)));
  Result<std::unique_ptr<FileBlobs>> blobs = FileBlobs::open(stores->data_folder() + "/blobs", &stores->reserve_);
  if (!blobs) return blobs.error();
  stores->blobs_ = std::move(*blobs);
  const SqliteSettings sqlite{stores->data_folder() + "/jobs.sqlite", settings.max_unrecorded, &stores->reserve_,
                              settings.report};
  Result<std::unique_ptr<SqliteStore>> store = SqliteStore::open(sqlite);
  if (!store && store.error().code == ErrorCode::storage_full) {  // its log has to be read before anything is deleted
    stores->reserve_.release();
    store = SqliteStore::open(sqlite);
  }
  if (!store) return store.error();
  stores->store_ = std::move(*store);
  stores->reserve_.restore();  // a later write tries again
  return stores;
}

}  // namespace meshgauge::server::store
