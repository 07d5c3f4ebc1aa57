#pragma once

namespace meshgauge::api {

// How many processors the calling thread may run on, as taskset, a container's set of processors or a queueing system
// say; at least 1. A container's share of processor time is not among them.
unsigned usable_processors();

}  // namespace meshgauge::api
