// Makes a LiveJob from a row of the store.
#pragma once

#include <memory>

#include "server/measure/live_job.h"
#include "server/settings/settings.h"
#include "server/store/blob_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

// Applies the settings that limit every comparison.
api::Request limited(api::Request request, const Settings& settings);

// Returns a job to run, without its bytes. A job whose options this version does not understand has a defect, and fails
// when it runs. `waited`: the time that it has waited in the store.
std::shared_ptr<LiveJob> live_job_of(const store::Job& row, const Settings& settings,
                                     std::chrono::milliseconds waited = {});

// Marks the meshes that are worth caching: those that their owner has stored as meshes.
Result<Done> recognise_meshes(LiveJob& job, store::MeshIndex& meshes);

// Opens the blobs of its meshes: a waiting job holds neither memory nor descriptors. A mesh that no longer exists is
// left without a holder.
Result<Done> open_blobs(LiveJob& job, store::BlobStore& blobs);

}  // namespace meshgauge::server
