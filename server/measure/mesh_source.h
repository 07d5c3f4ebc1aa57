// The source of one mesh of a comparison: an upload, or a blob of the store.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "api/compare/load.h"
#include "server/http/bundle.h"
#include "server/measure/mesh_cache.h"
#include "server/store/blob_store.h"

namespace meshgauge::server {

struct MeshSource {
  api::MeshInput input;                // borrows from `holder`
  std::shared_ptr<const void> holder;  // owns the bytes and their descriptor; null: not at hand
  std::string id;                      // of the blob; empty: never stored
  std::optional<MeshCache::Key> kept;  // of a mesh that its owner has stored (POST /v1/meshes)
};

MeshSource source_of(const std::string& part, MeshField mesh);
MeshSource source_of(const std::string& part, store::Blob blob, const std::string& id);

// Attach the bytes to the source, and drop them.
void hold_bytes(MeshSource& source, store::Blob blob);
void release_bytes(MeshSource& source);

// File names and media types of two sources as JSON for the store's `hints`, and back.
std::string hints_of(const MeshSource& a, const MeshSource& b);
void set_hints(const std::string& hints, MeshSource& a, MeshSource& b);

}  // namespace meshgauge::server
