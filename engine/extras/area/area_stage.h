// The stages of a measurement after its interval: the certified distribution over the area of each direction, and the
// extent on each side.
#pragma once

#include <functional>
#include <optional>

#include "engine/area.h"
#include "engine/control.h"
#include "engine/mesh/topology.h"
#include "engine/options.h"
#include "engine/search/measured_pair.h"
#include "engine/sides.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Answers `options.areas` for each direction of `pair` and fills `found`. A deadline, a cancellation or lack of memory
// ends it with the intervals reached so far: AreaBounds::stop; it does not throw std::bad_alloc. Calls `tell`
// repeatedly, on this thread, to report progress.
void take_areas(const MeasuredPair& pair, const Options& options, ThreadPool& pool, Control& control,
                const std::function<void()>& tell, AreaOutcome& found);

// Answers `options.sides` for the direction from mesh a to mesh b and fills `found`, likewise. Precondition: the pair
// has that direction.
void take_sides(const MeasuredPair& pair, const Options& options, ThreadPool& pool, Control& control,
                const std::function<void()>& tell, SideOutcome& found);

// Returns why a mesh of this topology has no sides; nullopt: it has.
std::optional<NoSides> refusal_of(const Topology& topology);

}  // namespace meshgauge
