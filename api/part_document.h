// A part of a comparison on its way from the worker that measured it to the one that puts the parts together. Internal:
// written and read by services of the same version, seen by no client.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "api/compare.h"
#include "api/request.h"

namespace meshgauge::api {

// Options for part `index` of request.shards: what the request asks for, with its share of the work items. Memory and
// threads are those of each part. Precondition: index < request.shards.
Options options_of_part(const Request& request, unsigned index);

// `part` as compare_prepared() gave it for options_of_part(). Compact; numbers round-trip.
std::string to_part_json(const Comparison& part);

// What to_part_json() wrote, byte for byte, and makes sense: bounds in order, indices within their meshes. Of the
// options only the part is known. An Error is `internal` and says what is wrong.
Result<Comparison> read_part(std::string_view json);

// The comparison that `documents`, one of each part of `request` in any order, are parts of, as if it had been measured
// at once; id and queue time are left to the caller. Stages take as long as in the slowest part each, since parts run
// at the same time; culling and work are sums. Status, rule and verdict follow from the merged interval
// (engine/part.h).
//
// An Error is `internal`: a document that cannot be read, is of another part, mesh, direction, engine or partition, or
// all together relied on a lower bound that none has in the end (a part reported one, was lost, and found less when it
// was measured again). Then the whole has to be measured at once, and can be.
Result<Comparison> merge_parts(std::span<const std::string> documents, const Request& request);

}  // namespace meshgauge::api
