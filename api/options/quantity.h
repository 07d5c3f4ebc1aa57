// Numbers of requests, manifests and flags: the range of each, and lengths, shares and durations as people write them.
#pragma once

#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "api/base/units.h"
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

// Returns "an integer from 1 to 64".
std::string described(const Range& range);

// Returns `value` when it is in the range, else invalid_request. `name`: a JSON pointer, a flag or a key, for the
// message and Error::where.
Result<double> in_range(double value, const Range& range, std::string_view name);

// What people write. Errors of the parsers are the end of a sentence; the caller adds the option or flag: "must be ...,
// not '5,0 mm'". Surrounding blanks are ignored.

struct Length {
  double number = 0;               // in `unit`; of a share: 0.01 is one percent
  std::optional<LengthUnit> unit;  // nullopt: none is given
  bool is_share = false;           // of the diagonal of mesh b's bounding box
};

// What may stand for a length, and for a limit.
inline constexpr std::string_view kLength = "a number (0.05) or a number and a unit (0.05 mm)";
inline constexpr std::string_view kLengthOrShare =
    "a number (0.05), a number and a unit (0.05 mm) or a share of the baseline's diagonal (0.5 %)";

// Parses "0.05", "0.05 mm" or "0.05mm", with the spellings of parse_unit(), and with `or_share` "0.5 %". Refuses a
// decimal comma, hexadecimal, negative or infinite numbers and any text after the number.
Result<Length> parse_length(std::string_view text, bool or_share);

// Parses a share, "1 %", as a fraction of 1. A number without '%' is refused: it would be read either way. `of`: of
// what, for the message.
Result<double> parse_share(std::string_view text, std::string_view of = "the area");

// Parses "60 s", "500 ms", "2 min" or "60s"; a bare number is in seconds. Rounds to whole milliseconds, from 1
// to `most`.
Result<std::chrono::milliseconds> parse_duration(std::string_view text, std::chrono::milliseconds most);

}  // namespace meshgauge::api
