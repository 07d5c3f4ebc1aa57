// Converts pieces of a result to JSON.
#pragma once

#include <optional>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "api/compare.h"

namespace meshgauge::api {

using Json = nlohmann::ordered_json;  // writes a number that is not finite as null

Json text_or_null(std::string_view text);  // null: the text is empty
Json json_of(const Vec3& p);
Json interval(double lower, double upper);
Json json_of(const Bounds& bounds);
Json json_of(const std::optional<Directed>& directed);
Json json_of(const Tolerance& asked);  // has only the rules that are set
// The limits of a request, as results, jobs and lists of failures show them; null: it has none.
Json gate_of(const ComparisonOptions& options);
Json json_of(const ShareLimit& limit);
Json json_of(const SideOptions::Zone& zone);  // [-inside, outside]
Json json_of(const KnownUnit& known);
Json json_of(const MeshFacts& facts, const KnownUnit& unit);
Json json_of(const std::optional<Topology>& topology);

}  // namespace meshgauge::api
