// What a caller may ask for at once: many comparisons, as one document.
//
//   {"name": "nightly", "options": {...}, "comparisons": [{"name": "bracket", "a": ID, "b": {"part": "b1"},
//   "options": {...}}, ...]}
//
// A mesh is the id of one that is stored, or names a part of the same request. The options of one comparison take the
// place of those of all, member by member.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "api/request.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::size_t kMaxBatchNameBytes = 255;  // of a batch, a comparison, or a part

struct BatchMesh {
  std::string id;    // 64 lower-case hex digits; empty: not stored
  std::string part;  // of the request; empty: none
};

struct BatchPair {
  std::string name;  // may be empty, and the same for several
  BatchMesh a;
  BatchMesh b;
  std::size_t options = 0;  // of BatchRequest::options
};

struct BatchRequest {
  std::string name;                  // may be empty
  std::vector<std::string> options;  // JSON, each valid, each once; equal options are the same text
  std::vector<BatchPair> pairs;      // not empty
};

struct BatchLimits {
  RequestLimits request;
  std::size_t max_pairs = 10'000;
  std::size_t max_bytes = std::size_t{16} << 20;
  bool parts = false;  // whether a mesh may name one
};

// Refused as by parse_options(); `document` is what the errors call it.
Result<BatchRequest> parse_batch(std::string_view json, const std::string& document, const BatchLimits& limits);

}  // namespace meshgauge::api
