// The deduplication key of a job.
#pragma once

#include <string>

#include "server/store/job_store.h"

namespace meshgauge::server {

// Returns store::BatchItem::work of the job as this process would run it: equal for jobs with the same result, so it
// depends on this process's version. The process that inserts a job stores its own key. The worker that has run the job
// stores its own key again, because during an upgrade it may have another version: results are found by the version
// that computed them.
std::string work_of(const store::NewJob& job);

}  // namespace meshgauge::server
