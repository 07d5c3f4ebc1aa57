// The engine's entry point: certified bounds of the Hausdorff distance between two triangle meshes.
//
//   h(A,B) = max over a in A of min over b in B of |a-b|        one-sided
//   H(A,B) = max(h(A,B), h(B,A))                                symmetric
//
// measure() returns lower <= distance <= upper, rounding included: docs/design.md and engine/rounding.h have the proof.
// The method is that of Zheng et al., "Economic Upper Bound Estimation in Hausdorff Distance Computation for Triangle
// Meshes", Computer Graphics Forum 2022 ("the paper").
#pragma once

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge {

// Measures the direction that the options ask for. Blocks until the tolerance is met or the gate decided, or until a
// deadline, a cancellation or a budget stops it: Outcome::stop says which. The interval holds in every case.
// Preconditions: both meshes pass validate(); options.simd is "auto" or in supported_simd(); with strategy n_point,
// is_stencil(options.points). Throws std::bad_alloc, nothing else.
// Deterministic with one thread: the same input and options give the same bits on every instruction set, unless the job
// is interrupted, or Options::narrow runs out of time. With more threads the interval may differ within the tolerance;
// gate verdicts never contradict each other. Statistics do not depend on the number of threads.
Outcome measure(MeshView a, MeshView b, const Options& options, Control& control);

// The engine's version, such as "0.2.0".
const char* version();

}  // namespace meshgauge
