// What a job is, for who looks whether the same was done before.
#pragma once

#include <string>

#include "server/store/job_store.h"

namespace meshgauge::server {

// store::BatchItem::work of the job, if this process does it: equal when the same result comes of it. So it is of this
// process's version too. Who asks says what he would do; who has done it says so anew, because while a fleet is
// upgraded any version runs the jobs of any other. What is kept is found by what was done.
std::string work_of(const store::NewJob& job);

}  // namespace meshgauge::server
