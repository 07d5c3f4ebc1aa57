// The first stage of a measurement: the frame of both meshes, then the orders and trees that the search needs.
#pragma once

#include <optional>

#include "engine/control.h"
#include "engine/kernels/kernels.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/search/measured_pair.h"
#include "engine/search/search.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Sets `frame` and, for both meshes, `framed`.
void enter_frame(MeasuredPair& pair, const Kernels& kernels, ThreadPool& pool);

// Sets `ordered` and `tree` of each mesh that a direction needs them of. With Strategy::automatic it first leaves out
// what needs neither: what front.h bounds by itself, or else the triangles that both meshes have, which are at distance
// 0. A direction of which nothing is left is settled. `goal` and `slack`: those of the searches to come.
// Returns nullopt, or the reason to stop: then nothing may be searched.
std::optional<Stop> build(MeasuredPair& pair, Strategy strategy, const Goal& goal, const Slack& slack, ThreadPool& pool,
                          Control& control);

}  // namespace meshgauge
