// All stores of a service, in one of two forms: on this machine (embedded.h), or in databases that several machines
// share (distributed.h).
#pragma once

#include <string>

#include "server/store/batch_store.h"
#include "server/store/blob_store.h"
#include "server/store/job_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/signals.h"

namespace meshgauge::server::store {

class AllStores {
 public:
  virtual ~AllStores() = default;

  virtual JobStore& jobs() = 0;
  virtual MeshIndex& meshes() = 0;
  virtual BatchStore& batches() = 0;
  virtual Listings& listings() = 0;
  virtual BlobStore& blobs() = 0;
  virtual Signals& signals() = 0;
  virtual bool shared() const = 0;  // other processes use these stores, too
  virtual const std::string& data_folder() const = 0;
};

}  // namespace meshgauge::server::store
