// A job of this process from a row of the store.
#pragma once

#include <memory>

#include "server/jobs/live_job.h"
#include "server/settings.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

// What the settings say of every comparison.
api::Request limited(api::Request request, const Settings& settings);

// A durable one, without its bytes at hand; one whose options this version does not understand has a defect, and fails
// when it runs. Errors: the index's.
Result<std::shared_ptr<LiveJob>> revived(const store::Job& row, const Settings& settings, store::MeshIndex& meshes);

}  // namespace meshgauge::server
