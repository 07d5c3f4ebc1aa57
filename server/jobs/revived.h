// A job of this process from a row of the store.
#pragma once

#include <memory>

#include "server/jobs/live_job.h"
#include "server/settings.h"
#include "server/store/blob_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

// What the settings say of every comparison.
api::Request limited(api::Request request, const Settings& settings);

// To be run, without its bytes; one whose options this version does not understand has a defect, and fails when it
// runs. `waited`: in the store, before now.
std::shared_ptr<LiveJob> live_job_of(const store::Job& row, const Settings& settings,
                                     std::chrono::milliseconds waited = {});

// Finds out which of its meshes are worth keeping in memory: those that their owner stored as such.
Result<Done> recognise_meshes(LiveJob& job, store::MeshIndex& meshes);

// While a durable job waits it holds neither memory nor descriptors: its bytes are in the store. What is not there any
// more is left without a holder.
Result<Done> open_blobs(LiveJob& job, store::BlobStore& blobs);

}  // namespace meshgauge::server
