// A part of a measurement: some of the triangles measured from, against all of those measured to.
//
// The triangles that are to be measured (all but those that lie in the other mesh as they are) stand along the
// space-filling curve (engine/curve.h) and are cut into runs of equal length; run r is of part r mod count. So every
// triangle is of exactly one part, whatever the count, and every part has its share of each region: none has to search
// for long without a lower bound that is near the whole's. The same meshes are cut the same way on every machine.
//
// The whole from its parts. Let A_i be the part of A, l_i and u_i the certified interval of part i. Then
//
//     h(A,B) = max over i of h(A_i,B)     and so     max over i of l_i <= h(A,B) <= max over i of u_i,
//
// since l_i <= h(A_i,B) <= u_i for each i. That each of these holds alone, for whatever lower bound L a part was told
// of (Control::know_lower), is docs/design.md, section 4: L is one more number that discards are held against, and
// upper() contains it and every bound that was ever discarded. So u_i >= h(A_i,B) even for an L that is nobody's lower
// bound: such a one makes u_i wide, never wrong. l_i comes from part i's own witness, never from L. Hence the interval
// of the whole holds for every count, every order and interleaving of the parts, and whatever ended each of them:
// deadline, cancellation, budget, gate. All parts look at the same two meshes, so they have the same frame; their
// intervals are in the meshes' unit, rounded outwards, and a maximum rounds nothing.
//
// It is tight, too: where every L that was told is at most the greatest l_i in the end, a part that ended by itself has
// u_i <= max(l_i, L) + gap <= (greatest l) + gap, `gap` the width that was asked for.
//
// Of a symmetric measurement each part has triangles of one of the two directions alone, so that it needs the tree of
// one mesh alone; how many parts a direction has goes by its triangles. L is a lower bound of the greater distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/hausdorff.h"
#include "engine/large_array.h"

namespace meshgauge {

// How the triangles are cut: parts of measurements may be put together only where this number was the same.
inline constexpr unsigned kPartition = 1;

// What a part is of: a direction, and a part of that. Precondition: part.index < part.count.
struct Share {
  Direction direction;
  Part part;
};
Share share_of(const Part& part, Direction direction, std::size_t triangles_a, std::size_t triangles_b);

// Those of `order` that are of `part` of one direction, in order. Precondition of both: part.index < part.count.
LargeArray<std::uint32_t> of_part(std::span<const std::uint32_t> order, const Part& part);
// How many there are of `triangles`. The sum over all parts is `triangles`.
std::size_t size_of_part(std::size_t triangles, const Part& part);

// The outcome of the whole from those of all its parts, as if it had been measured at once: intervals, witness, rule
// and stop; culling and work are sums, and timings the greatest, as the parts may run at the same time. `options` are
// those of the whole. Precondition: one outcome of each part, all of the same two meshes.
Outcome joined(std::span<const Outcome> parts, const Options& options);

// Whether parts stopped by a lower bound that none of them has in the end, its finder being lost or its bound rounded
// outward: then nothing but that explains the width of the interval, which holds nevertheless. The whole is to be
// measured in one piece.
bool relies_on_lost(const Outcome& joined);

}  // namespace meshgauge
