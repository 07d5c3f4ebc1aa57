// The request of a comparison: one document, the same on every surface (api/options/surface.h), and one reader.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/options/comparison_options.h"
#include "api/options/quantity.h"
#include "api/options/reading.h"
#include "api/options/surface.h"
#include "engine/result.h"

namespace meshgauge::api {

inline constexpr std::size_t kMaxOptionsBytes = std::size_t{64} << 10;

// A gate ends when its limit is decided: an interval of one percent could still contain the limit. One that limits the
// area or the sides alone needs no narrow interval of the distance, which is only shown.
inline constexpr Tolerance kToleranceOfGate{std::nullopt, 1e-9, std::nullopt};
inline constexpr Tolerance kToleranceOfArea{std::nullopt, 1e-3, 0.1};

struct Request {
  ComparisonOptions options;
  bool threads_given = false;                 // false: the caller chooses the number of threads
  std::chrono::milliseconds timeout{30'000};  // for the whole job: waiting, reading, measuring
};

struct RequestLimits {
  std::chrono::milliseconds default_timeout{30'000};
  std::chrono::milliseconds max_timeout{180'000};
};

struct ReadRequest {
  Request request;
  std::vector<RequestMistake> mistakes;  // if any: `request` is not whole
};

// Reads the document (openapi.yaml, Options). Every member is optional. When `tolerance` is given, only
// the rules in it apply; without it a limit that stands outside of `gate` has kToleranceOfGate or kToleranceOfArea.
ReadRequest read_request(const nlohmann::json& document, const Surface& surface, const RequestLimits& limits = {});

// As read_request(), of options that others will complete: what does not fit each other is no mistake yet.
std::vector<RequestMistake> mistakes_in_part(const nlohmann::json& document, const Surface& surface);

// The options of a surface, in the order of the table.
std::vector<std::string_view> options_of(const Surface& surface);

std::vector<std::string> limit_names();         // of the options of which a gate needs one, max_distance first
bool is_about_limits(std::string_view option);  // whether it is one of them, or goes with them alone

// Writes what read_request() of HTTP reads as the same request; `gate` has all limits. Without threads unless
// threads_given.
nlohmann::ordered_json json_of(const Request& request);

// Parses the `options` document of HTTP: an object of at most 64 KiB, nested at most 16 deep. Errors: too_large; else
// invalid_request, with a JSON pointer in Error::where ("byte N" for a syntax error), for each mistake one, the others
// in Error::others.
Result<Request> parse_options(std::string_view json, const RequestLimits& limits = {}, const Surface& surface = kHttp);

// Returns the mistakes as one Error. Precondition: there are some.
Error error_of(const std::vector<RequestMistake>& mistakes);

// Returns the instruction set of this name for Options::simd; "auto": the fastest. Error: invalid_request with the list
// of names when this processor cannot run it.
Result<std::string_view> as_simd(std::string_view value, std::string_view name);

// Returns the names that as_simd() accepts on this processor: "auto, avx2, sse4, scalar".
std::string simd_names();

// A comparison of two stored meshes: {"a": id, "b": id, "options": {...}}; options are optional.
struct StoredPair {
  std::string a;  // the meshes' ids: 64 lower-case hex digits
  std::string b;
  std::string options = "{}";  // for parse_options()
};

// Parses a comparison of stored meshes, without checking its options. Errors: as for parse_options().
Result<StoredPair> parse_stored_pair(std::string_view json);

}  // namespace meshgauge::api
