// Names of values in a manifest and in flags, beside those of the API (api/names.h).
#pragma once

#include "api/names.h"

namespace meshgauge::check {

inline constexpr api::Name<bool> kOnFail[] = {{false, "fail"}, {true, "warn"}};  // values of Gate::warn_only
inline constexpr api::Name<bool> kUnmatchedBaselines[] = {{false, "error"},
                                                          {true, "ignore"}};  // values of Entry::unmatched_ignored

}  // namespace meshgauge::check
