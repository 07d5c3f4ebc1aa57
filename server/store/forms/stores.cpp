#include "server/store/forms/stores.h"

#include "server/store/blob_cache.h"
#include "server/store/file_blobs.h"
#include "server/store/postgres/pg_blobs.h"
#include "server/store/postgres/shared_reservations.h"
#include "server/store/s3/s3_blobs.h"

namespace meshgauge::server::store {
namespace {

Result<std::unique_ptr<RemoteBlobs>> remote_blobs(const DistributedSettings& settings, PostgresStore& store) {
  if (settings.blobs.empty()) return std::unique_ptr<RemoteBlobs>(new PgBlobs(store.pool()));
  Result<S3Settings> s3 =
      s3_settings(settings.blobs, settings.s3_endpoint, settings.s3_region, settings.s3_virtual_host);
  if (!s3) return s3.error();
  return std::unique_ptr<RemoteBlobs>(new S3Blobs(*std::move(s3), {}, {}, settings.report));
}

}  // namespace

Result<std::unique_ptr<AllStores>> AllStores::open_embedded(const EmbeddedSettings& settings) {
  Result<DataFolder> folder = DataFolder::open(settings.data_folder);
  if (!folder) return folder.error();
  std::unique_ptr<AllStores> stores(new AllStores(std::move(*folder), false));
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
  stores->database_ = std::move(*store);
  stores->reserve_.restore();  // a later write tries again
  return stores;
}

Result<std::unique_ptr<AllStores>> AllStores::open_distributed(const DistributedSettings& settings) {
  Result<DataFolder> folder = DataFolder::open(settings.data_folder);
  if (!folder) return folder.error();
  std::unique_ptr<AllStores> stores(new AllStores(std::move(*folder), true));
  Result<std::unique_ptr<PostgresStore>> store =
      PostgresStore::open({settings.database, settings.max_connections, settings.call_timeout, settings.duty_grace,
                           settings.max_unrecorded, settings.report});
  if (!store) return store.error();
  PostgresStore& database = **store;
  stores->database_ = std::move(*store);
  Result<std::unique_ptr<RemoteBlobs>> remote = remote_blobs(settings, database);
  if (!remote) return remote.error();
  Result<std::unique_ptr<BlobCache>> cache =
      BlobCache::open(stores->data_folder() + "/cache", settings.blob_cache_bytes);
  if (!cache) return cache.error();
  stores->blobs_ = std::make_unique<CachedBlobs>(std::move(*remote), std::move(*cache),
                                                 std::make_unique<SharedReservations>(settings.database));
  return stores;
}

}  // namespace meshgauge::server::store
