// Writes options of a request as JSON, in the form in which a request has them.
#pragma once

#include <optional>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "api/options/comparison_options.h"
#include "engine/extras/align/align.h"
#include "engine/mesh.h"
#include "engine/options.h"
#include "engine/region.h"

namespace meshgauge::api {

using Json = nlohmann::ordered_json;  // writes a number that is not finite as null

Json text_or_null(std::string_view text);  // null: the text is empty
Json number_or_null(const std::optional<double>& number);
Json json_of(const Vec3& p);
Json json_of(const Tolerance& asked);  // has only the rules that are set
Json json_of(const Region& region);
Json json_of(const Expectations& expect);  // members in a fixed order; a count of one value is a number
Json json_of(const AlignOptions& options);
Json json_of(const RigidMotion& motion);  // {"row_major": [16 numbers]}
// The limits of a request, as results, jobs and lists of failures show them; null: it has none.
Json gate_of(const ComparisonOptions& options);

}  // namespace meshgauge::api
