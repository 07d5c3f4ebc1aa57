// The last stage of a measurement: statistics of sampled distances, once the interval is final.
#pragma once

#include <functional>

#include "engine/control.h"
#include "engine/search/measured_pair.h"
#include "engine/statistics.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Samples each direction of `pair` and fills `statistics`. On a deadline, a cancellation or lack of memory it sets
// `status` and keeps the directions that were done; it does not throw std::bad_alloc. Calls `tell` repeatedly, on this
// thread, to report progress.
void take_statistics(const MeasuredPair& pair, const Sampling& sampling, ThreadPool& pool, Control& control,
                     const std::function<void()>& tell, Statistics& statistics);

}  // namespace meshgauge
