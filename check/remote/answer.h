// What the service says, read with suspicion: its answers may be those of anything that listens at the address.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "check/gate.h"
#include "engine/control.h"
#include "engine/result.h"
#include "net/http_client.h"

namespace meshgauge::check::service {

// An RFC 9457 problem document of the service.
struct Problem {
  std::string slug;  // "unknown-mesh"
  std::string detail;
  std::string part;  // of its first error: "a", "b", "options"; may be empty
  std::string where;
};

// nullopt: it is none.
std::optional<Problem> problem_from(const nlohmann::ordered_json& json);
std::optional<Problem> problem_from(std::string_view body);

// A comparison as it stands (openapi.yaml, "Job").
struct Job {
  std::string id;
  std::string state;  // "queued", "running", "done", "failed", "cancelled"
  Progress progress;
  std::optional<nlohmann::ordered_json> result;
  std::optional<Problem> problem;

  bool ended() const { return state != "queued" && state != "running"; }
};

// A batch as it stands (openapi.yaml, "Batch").
struct BatchState {
  std::string id;
  std::string view;  // the path of its page, "/b/{id}"; empty: the service does not say that
  bool finished = false;
  std::size_t total = 0;  // comparisons
  std::size_t ended = 0;  // of them; at most all
};

// A line of a batch's results (openapi.yaml, "BatchResult").
struct BatchLine {
  std::size_t position = 0;  // in the batch
  std::optional<Job> job;    // ended; none: the service has its result no more
};

// nullopt: not JSON, nested too deep, or not what it should be.
std::optional<nlohmann::ordered_json> document_from(std::string_view body);
std::optional<nlohmann::ordered_json> comparison_from(std::string_view body);
std::optional<Job> job_from(std::string_view body);
std::optional<BatchState> batch_from(std::string_view body);
std::optional<BatchLine> batch_line_from(std::string_view line);

// The time of its run, as a comparison says; nullopt: it does not.
std::optional<double> run_ms(const nlohmann::ordered_json& comparison);

// Takes away where the service shows the comparison: the path of that page, "/c/{id}", or empty when it does not say
// that.
std::string take_view(nlohmann::ordered_json& comparison);

// Of the mesh "a" or "b" of a comparison; empty when it has none.
std::string sha256_of(const nlohmann::ordered_json& comparison, const char* part);

// Whether it was measured in the gate's direction, against that limit to the last bit, and in the gate's units: a
// service that takes a unit for a label gives none.
bool is_answer_to(const nlohmann::ordered_json& comparison, const Gate& gate, double max_distance);

// `base` is the service's address, for the messages. A message about a mesh is that of the same mesh measured here.
Error error_of(const Problem& problem, const Gate& gate, const std::string& base);
// Of a reply that is no success.
Error error_of(const net::HttpAnswer& reply, const Gate& gate, const std::string& base, bool has_key);
Error not_a_service(const std::string& base, const std::string& what);

}  // namespace meshgauge::check::service
