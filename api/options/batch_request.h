// A batch request: many comparisons in one JSON document.
//
//   {"name": "nightly", "options": {...}, "comparisons": [{"name": "bracket", "a": ID, "b": {"part": "b1"},
//   "options": {...}}, ...]}
//
// A mesh is the id of a stored mesh or names a part of the same request. The options of a comparison override the
// options of the batch, member by member.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "api/options/request.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::size_t kMaxBatchNameBytes = 255;  // for the name of a batch, a comparison or a part

struct BatchMesh {
  std::string id;    // 64 lower-case hex digits; empty: `part` names the mesh
  std::string part;  // name of a part of the request; empty: `id` names the mesh
};

// Whether the text is the id of a mesh: 64 lower-case hex digits.
bool is_mesh_id(std::string_view text);

struct BatchPair {
  std::string name;  // may be empty; need not be unique
  BatchMesh a;
  BatchMesh b;
  std::size_t options = 0;  // index into BatchRequest::options
};

struct BatchRequest {
  std::string name;                  // may be empty
  std::vector<std::string> options;  // distinct valid options documents (JSON); equal options are one entry
  std::vector<BatchPair> pairs;      // not empty
};

struct BatchLimits {
  RequestLimits request;
  std::size_t max_pairs = 10'000;
  std::size_t max_bytes = std::size_t{16} << 20;
  bool parts = false;  // true: a mesh may name a part of the request
};

// Parses a batch and checks every options document in it. `document` is its name in errors. Errors: as for
// parse_options(); too_large for more than max_pairs comparisons or max_bytes bytes.
Result<BatchRequest> parse_batch(std::string_view json, const std::string& document, const BatchLimits& limits);

}  // namespace meshgauge::api
