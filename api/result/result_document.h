// Reads a comparison's result document (openapi.yaml, "Comparison"), which api/result/response.h writes.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "api/compare/unit_plan.h"
#include "api/result/criteria.h"
#include "engine/mesh.h"
#include "engine/mesh/rigid.h"
#include "engine/result.h"

namespace meshgauge::api {

enum class Side { a, b };

// Where `lower` is attained: a point of one mesh and the nearest point of the other.
struct ResultWitness {
  bool on_candidate = true;  // true: `from` lies on the candidate; false: on the baseline
  Vec3 from = Vec3::Zero();
  std::uint32_t from_triangle = 0;  // 0-based index in the mesh as read
  Vec3 to = Vec3::Zero();
  std::uint32_t to_triangle = 0;

  // The mesh of `from`, and that of `to`: "candidate" or "baseline".
  std::string from_mesh() const { return on_candidate ? "candidate" : "baseline"; }
  std::string to_mesh() const { return on_candidate ? "baseline" : "candidate"; }
};

// The certified interval of one direction.
struct ResultDirection {
  double lower = 0;
  double upper = 0;
  std::optional<ResultWitness> witness;
};

struct ResultFacts {
  std::optional<DistanceLimit> limit;  // shown_limit() of the criteria
  double lower = 0;                    // the certified interval; `upper` is infinite when there is no upper bound yet
  double upper = std::numeric_limits<double>::infinity();
  std::optional<ResultWitness> witness;      // for the direction that attains `lower`
  std::optional<ResultDirection> direction;  // from the candidate to the baseline; nullopt: not measured
  UnitPlan units;                            // of both files; `result` is the unit of every length here
  std::optional<RigidMotion> motion;         // of mesh a before it was measured, in that unit; nullopt: none
  bool sides = false;                        // whether the candidate's sides of the other mesh were asked for
  std::string no_sides{};                    // why there are none: "the baseline is open: ..."; empty: not refused
  bool has_units = false;                    // false: written before version 0.2.0, without units
};

// Reads a result document. `candidate`: the mesh that the facts are about. Error: internal when the document is not a
// result or its bounds are not an interval.
Result<ResultFacts> result_facts(const nlohmann::ordered_json& document, Side candidate);

// Returns a point [x, y, z]. Throws nlohmann::json::exception when it is none.
Vec3 point_of(const nlohmann::ordered_json& point);

// Returns the upper bound of an interval {"lower": ..., "upper": ...}; null: infinity, there is none yet. A result that
// this version writes always has one: it is known before the search begins. Throws nlohmann::json::exception when it
// is neither.
double upper_of(const nlohmann::ordered_json& interval);

// Reads the units of a result document. A missing or unknown unit is nullopt, which converts nothing.
UnitPlan unit_plan_of(const nlohmann::ordered_json& document);

}  // namespace meshgauge::api
