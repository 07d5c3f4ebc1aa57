// The bytes of one mesh of a comparison, wherever they are: an upload, or a blob of the store.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "api/load.h"
#include "server/handlers/comparison_form.h"
#include "server/jobs/mesh_cache.h"
#include "server/store/blob_store.h"

namespace meshgauge::server {

struct MeshSource {
  api::MeshInput input;                // borrows from what `holder` keeps
  std::shared_ptr<const void> holder;  // of the bytes and their descriptor
  std::string id;                      // of the stored mesh; empty: never stored
  std::optional<MeshCache::Key> kept;  // of a mesh that its owner stored to compare it often
};

MeshSource source_of(const std::string& part, MeshField mesh);
MeshSource source_of(const std::string& part, store::Blob blob, const std::string& id);

// The same source, with and without its bytes at hand.
void hold_bytes(MeshSource& source, store::Blob blob);
void release_bytes(MeshSource& source);

// What is known of two sources beside their bytes, as JSON for the store's `hints`, and back.
std::string hints_of(const MeshSource& a, const MeshSource& b);
void set_hints(const std::string& hints, MeshSource& a, MeshSource& b);

}  // namespace meshgauge::server
