#include "server/main/open_stores.h"

#include <utility>

#include "server/observe/log.h"
#include "server/store/forms/distributed.h"
#include "server/store/forms/embedded.h"

namespace meshgauge::server {
namespace {

void report(const std::string& line) { log_event("store", line); }

store::DistributedSettings distributed(const Settings& settings) {
  store::DistributedSettings asked;
  asked.database = settings.database;
  asked.blobs = settings.blobs;
  asked.s3_endpoint = settings.s3_endpoint;
  asked.s3_region = settings.s3_region;
  asked.s3_virtual_host = settings.s3_virtual_host;
  asked.blob_cache_bytes = settings.blob_cache_bytes;
  asked.data_folder = settings.data_dir;
  asked.report = report;
  return asked;
}

template <class Stores>
Result<std::unique_ptr<store::AllStores>> opened(Result<std::unique_ptr<Stores>> stores) {
  if (!stores) return stores.error();
  return std::unique_ptr<store::AllStores>(std::move(*stores));
}

}  // namespace

Result<std::unique_ptr<store::AllStores>> open_stores(const Settings& settings) {
  if (is_distributed(settings)) return opened(store::DistributedStores::open(distributed(settings)));
  return opened(store::EmbeddedStores::open({settings.data_dir, store::EmbeddedSettings().max_unrecorded, report}));
}

Stores stores_of(store::AllStores& all, MeshCache& cache, MapCache* maps) {
  return {all.jobs(),   all.meshes(), all.blobs(),    all.signals(),  cache,
          all.shared(), maps,         &all.batches(), &all.listings()};
}

}  // namespace meshgauge::server
