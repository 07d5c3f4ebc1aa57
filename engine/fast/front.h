// The front of strategy `auto`: leaves out most of A before anything is ordered and before a tree is built.
//
// Where both meshes have the same triangle indices, the movements of the vertices bound each triangle of A in one pass
// (Movement); where the meshes are far from each other, single points of B do (PointFront). A few distances of vertices
// give a lower bound L. The triangles whose bounds are within the tolerance of L are left out; the rest, usually a few
// dozen, goes through the search, together with the triangles of B that can be nearest to it (vicinity.h). Often the
// rest is the vertex alone that L is the distance of.
//
// The lower bound that the front culls against is a guess: the search measures anew what it reports. It follows that
// the front needs no proof beyond that of
//
//   left_out   the largest bound of a triangle that was left out goes into Search::upper();
//   reach      a triangle of B that is not in `near` is farther than this from each triangle of the rest, and the
//              certified lower bound never exceeds it (certify.h).
//
// The choice depends on the two meshes and the goal alone, not on what is kept of the meshes: kept meshes and new ones
// give the same bits.
#pragma once

#include "engine/control.h"
#include "engine/search/measured_pair.h"
#include "engine/search/search.h"
#include "engine/thread_pool.h"

namespace meshgauge {

enum class FrontEnd {
  declined,     // the direction is as it was: search all of it
  taken,        // the direction's `rest`, `near` and `left_out` are set, or it is settled
  interrupted,  // the job must end
};

// Tries to leave out most of `direction.from`. `known`: a computed distance that need not be exceeded, from the other
// direction; raised to what this direction has found. `slack`: without B's residual.
FrontEnd take_front(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, Slack slack,
                    double& known, Control& control, ThreadPool& pool);

}  // namespace meshgauge
