// The options of a comparison from JSON or flags, and their ranges.
#pragma once

#include <chrono>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

#include "api/comparison_options.h"
#include "engine/result.h"

namespace meshgauge::api {

// Inclusive at both ends; NaN is in no range.
struct Range {
  double low = 0;
  double high = std::numeric_limits<double>::max();
  bool integer = false;
};

inline constexpr Range kToleranceRange{};               // absolute, diagonal, relative; 0: as tight as rounding allows
inline constexpr Range kMaxDistanceRange{};             // limit of the gate, in the unit of the result
inline constexpr Range kThreadsRange{1, 64, true};      // per job; a service may grant fewer
inline constexpr Range kWorkItemsRange{1, 1e15, true};  // number of pieces split
inline constexpr Range kMemoryBytesRange{1 << 20, 0x1p40, true};  // for waiting pieces; a service may grant less
inline constexpr Range kTimeoutMsRange{1, 180'000, true};         // a service may set a lower maximum
inline constexpr Range kSamplesRange{1'000, 1'000'000, true};     // per direction of the statistics
inline constexpr Range kSeedRange{0, 0x1p53 - 1, true};           // integers that JSON readers keep exactly
inline constexpr Range kBeyondRange{};                            // a distance, in the unit of the result
inline constexpr Range kShareRange{0, 1};                         // of the area, a limit of the gate
inline constexpr Range kQuantileRange{0.001, 0.999};              // a share of the area
inline constexpr Range kCountRange{0, 0x1p32, true};              // of triangles, or of components
inline constexpr Range kShareToleranceRange{1e-6, 1};  // of certified areas; a service may need long for less
inline constexpr Range kLengthToleranceRange{1e-6, 1};
inline constexpr std::size_t kMaxOptionsBytes = std::size_t{64} << 10;

// Returns `value` when it is in the range, else invalid_request. `name`: a JSON pointer or a flag, for the message and
// Error::where.
Result<double> in_range(double value, const Range& range, std::string_view name);

// Returns the number of samples per piece for the strategy n_point. Error: invalid_request for a number that is not one
// of those allowed.
Result<int> as_points(double value, std::string_view name);

// Returns the instruction set of this name for Options::simd; "auto": the fastest. Error: invalid_request with the list
// of names when this processor cannot run it.
Result<std::string_view> as_simd(std::string_view value, std::string_view name);

// Returns the names that as_simd() accepts on this processor: "auto, avx2, sse4, scalar".
std::string simd_names();

// Returns invalid_request when `points_given` and the strategy is not n_point.
Result<Done> check_points(bool points_given, Strategy strategy, std::string_view name);

struct Request {
  ComparisonOptions options;
  bool threads_given = false;                 // false: the caller chooses the number of threads
  std::chrono::milliseconds timeout{30'000};  // for the whole job: waiting, reading, measuring
};

struct RequestLimits {
  std::chrono::milliseconds default_timeout{30'000};
  std::chrono::milliseconds max_timeout{180'000};
};

// Parses the `options` document: an object of at most 64 KiB, nested at most 16 deep; every field is optional. When
// `tolerance` is given, only the rules in it apply. Errors: too_large; else invalid_request, with a JSON pointer in
// Error::where ("byte N" for a syntax error), for a duplicate or unknown key, a wrong type or a value out of range.
Result<Request> parse_options(std::string_view json, const RequestLimits& limits = {});

// A comparison of two stored meshes: {"a": id, "b": id, "options": {...}}; options are optional.
struct StoredPair {
  std::string a;  // the meshes' ids: 64 lower-case hex digits
  std::string b;
  std::string options = "{}";  // for parse_options()
};

// Parses a comparison of stored meshes, without checking its options. Errors: as for parse_options().
Result<StoredPair> parse_stored_pair(std::string_view json);

}  // namespace meshgauge::api
