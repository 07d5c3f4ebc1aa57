// How far a compressed file may expand.
#pragma once

#include "api/formats/source.h"

namespace meshgauge::api {

// At most `limits.max_expanded_bytes` and, beyond the first 64 MiB, 200 times the compressed size: no mesh of numbers
// compresses so well, and it bounds time and memory by what was sent.
std::size_t expansion_limit(std::size_t compressed_bytes, const ReadLimits& limits);

// `kind`: "gzip" or "zip".
Error expands_too_far(std::string_view part, std::size_t limit, std::size_t compressed_bytes, std::string_view kind);

}  // namespace meshgauge::api
