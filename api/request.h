// What a caller may ask for: the options of a comparison, from JSON or from flags, under one table of ranges.
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
inline constexpr Range kMaxDistanceRange{};             // of the gate, in the unit of the result
inline constexpr Range kThreadsRange{1, 64, true};      // of one job; a service may grant fewer
inline constexpr Range kWorkItemsRange{1, 1e15, true};  // pieces split
inline constexpr Range kMemoryBytesRange{1 << 20, 0x1p40, true};  // of waiting pieces; a service may grant less
inline constexpr Range kTimeoutMsRange{1, 180'000, true};         // a service may set a smaller end
inline constexpr Range kSamplesRange{1'000, 1'000'000, true};     // of the statistics of one direction
inline constexpr Range kSeedRange{0, 0x1p53 - 1, true};           // every number that JSON's readers keep exactly
inline constexpr std::size_t kMaxOptionsBytes = std::size_t{64} << 10;

// `name` is a JSON pointer or a flag and comes back in the message and in Error::where.
Result<double> in_range(double value, const Range& range, std::string_view name);

// The number of samples that n_point takes of a piece.
Result<int> as_points(double value, std::string_view name);

// The instruction set of this name, or the fastest for "auto", as Options::simd takes it: refused, with the list of
// those that there are, when this processor cannot run it.
Result<std::string_view> as_simd(std::string_view value, std::string_view name);

// "auto, avx2, sse4, scalar": what as_simd() takes on this processor.
std::string simd_names();

// A number of samples means something to n_point only.
Result<Done> check_points(bool points_given, Strategy strategy, std::string_view name);

struct Request {
  ComparisonOptions options;
  bool threads_given = false;                 // else it is its caller's to say how many
  std::chrono::milliseconds timeout{30'000};  // of the whole job: waiting, reading, measuring
};

struct RequestLimits {
  std::chrono::milliseconds default_timeout{30'000};
  std::chrono::milliseconds max_timeout{180'000};
};

// The `options` document: an object of at most 64 KiB, nested at most 16 deep; every field is optional.
// Refused, with the JSON pointer in Error::where: a syntax error (where: "byte N"), a duplicate or unknown
// key, a wrong type, a value out of range. When `tolerance` is given, only the rules in it apply.
Result<Request> parse_options(std::string_view json, const RequestLimits& limits = {});

// A comparison of two stored meshes, as a document: {"a": id, "b": id, "options": {...}}, the last one optional.
struct StoredPair {
  std::string a;  // the meshes' ids: 64 lower-case hex digits
  std::string b;
  std::string options = "{}";  // for parse_options()
};

// Refused as by parse_options().
Result<StoredPair> parse_stored_pair(std::string_view json);

bool is_mesh_id(std::string_view text);

}  // namespace meshgauge::api
