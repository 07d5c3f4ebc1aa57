// The limit to which a compressed file may expand.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// Returns min(limits.max_expanded_bytes, max(64 MiB, 200 * compressed_bytes)), in bytes. The ratio bounds time and
// memory by the size sent; meshes compress far less.
std::size_t expansion_limit(std::size_t compressed_bytes, const ReadLimits& limits);

// Returns the too_large error for more than `limit` bytes. `kind`: the compression, such as "gzip".
Error expands_too_far(std::string_view part, std::size_t limit, std::size_t compressed_bytes, std::string_view kind);

}  // namespace meshgauge::api
