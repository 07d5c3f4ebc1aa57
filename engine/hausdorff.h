// The face of the engine: bounds of the Hausdorff distance between two triangle meshes.
//
//   h(A,B) = max over a in A of min over b in B of |a-b|        one-sided
//   H(A,B) = max(h(A,B), h(B,A))                                symmetric
//
// measure() returns lower <= distance <= upper, certified: rounding included (docs/design.md, engine/rounding.h).
// The method is that of Zheng et al., "Economic Upper Bound Estimation in Hausdorff Distance Computation
// for Triangle Meshes", Computer Graphics Forum 2022 ("the paper").
#pragma once

#include "engine/control.h"
#include "engine/mesh.h"
#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge {

// Precondition: both meshes pass validate(), is_stencil(options.points) for n_point, options.simd is supported. Out of
// time, budget or patience it returns the interval reached; std::bad_alloc is all it throws. With one thread
// deterministic: same input and options, same bits, unless interrupted, whatever the instruction set. With more the
// interval may differ within what was asked for, never a verdict that was given. Statistics are the same with any
// number.
Outcome measure(MeshView a, MeshView b, const Options& options, Control& control);

const char* version();  // of the engine, "0.2.0"

}  // namespace meshgauge
