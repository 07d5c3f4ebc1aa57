// The winding number of a closed, oriented surface around a point, by counting where a ray passes through it.
//
// Statement. Let each edge of B be passed as often in one direction as in the other, and let a ray from p, which is not
// on B, meet no edge of B. Then the winding number of B around p is the number of triangles that the ray leaves through
// their front less the number of those that it enters by. Proof: the number is constant off B, changes by one across a
// triangle that the ray meets in its interior, and is 0 far away. Triangles of no area are met at their edges only.
//
// The ray is sheared: along an axis z, the point p + z (s, t, 1) for z >= 0 or z <= 0. With q = v - p for a corner v,
// the point (q_x - s q_z, q_y - t q_z) shows where the triangle lies around the ray: it is met if the three edge
// functions have one sign, and that is also the sign of its passing.
//
// Rounding: rounding.h R16. A sign that rounding leaves open makes the ray useless; another one is tried. Nothing is
// ever decided by an uncertain sign.
#pragma once

#include <optional>

#include "engine/outcome.h"
#include "engine/tree/bvh.h"

namespace meshgauge {

// Returns the winding number of the tree's mesh around p, which lies in the unit frame. nullopt: rounding leaves it
// open with every ray, as it does when p is on the mesh; or `stop`, polled about every 0.1 ms, returned true. Thread
// safe. Precondition: as many triangles pass each edge in one direction as in the other.
std::optional<int> winding_number(const Bvh& tree, const Vec3& p, Work& work, const Interrupted* stop = nullptr);

}  // namespace meshgauge
