#include "server/store/embedded.h"

namespace meshgauge::server::store {

Result<std::unique_ptr<EmbeddedStores>> EmbeddedStores::open(const EmbeddedSettings& settings) {
  Result<DataFolder> folder = DataFolder::open(settings.data_folder);
  if (!folder) return folder.error();
  std::unique_ptr<EmbeddedStores> stores(new EmbeddedStores(std::move(*folder)));
  Result<std::unique_ptr<FileBlobs>> blobs = FileBlobs::open(stores->data_folder() + "/blobs");
  if (!blobs) return blobs.error();
  stores->blobs_ = std::move(*blobs);
  Result<std::unique_ptr<SqliteStore>> store =
      SqliteStore::open(stores->data_folder() + "/jobs.sqlite", settings.max_unrecorded, settings.report);
  if (!store) return store.error();
  stores->store_ = std::move(*store);
  return stores;
}

}  // namespace meshgauge::server::store
