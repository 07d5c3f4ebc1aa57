// What a comparison's document says (openapi.yaml, "Comparison"): the reader of what api/response.h writes.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "api/unit_plan.h"
#include "engine/mesh.h"
#include "engine/result.h"

namespace meshgauge::api {

enum class Side { a, b };

// Where the distance is at least `lower`: a point of one mesh, and the point of the other that is nearest to it.
struct ResultWitness {
  bool on_candidate = true;  // `from` lies on the candidate
  Vec3 from = Vec3::Zero();
  std::uint32_t from_triangle = 0;  // 0-based, of the files
  Vec3 to = Vec3::Zero();
  std::uint32_t to_triangle = 0;
};

// What is certified of one direction.
struct ResultDirection {
  double lower = 0;
  double upper = 0;
  std::optional<ResultWitness> witness;
};

struct ResultFacts {
  std::optional<double> limit;  // none: no gate
  double lower = 0;             // the certified interval; `upper` is infinite when the work ended before there was one
  double upper = std::numeric_limits<double>::infinity();
  std::optional<ResultWitness> witness;      // of the direction that attains `lower`
  std::optional<ResultDirection> direction;  // from the candidate to the other mesh; none: not measured
  UnitPlan units;                            // of the meshes as read, and of every length here
  bool has_units = false;                    // false: of a version before 0.2.0, which did not say
};

// `candidate`: which of the two meshes is looked at. internal: it is no such document, or its interval is none.
Result<ResultFacts> result_facts(const nlohmann::ordered_json& document, Side candidate);

// What is missing or is none of the names that a document has is not known: nothing is converted by it.
UnitPlan unit_plan_of(const nlohmann::ordered_json& document);

}  // namespace meshgauge::api
