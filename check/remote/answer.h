// Parses and checks the answers of a service. They are untrusted: anything may listen at the address.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
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

// nullopt: not a problem document.
std::optional<Problem> problem_from(const nlohmann::ordered_json& json);
std::optional<Problem> problem_from(std::string_view body);

// How a comparison ended: a document, or why there is none.
struct End {
  std::optional<nlohmann::ordered_json> document;
  std::optional<Problem> problem;
};

// The state of a batch (openapi.yaml, "Batch").
struct BatchState {
  std::string id;
  std::string view;  // the path of its page, "/b/{id}"; empty: the service does not say that
  bool finished = false;
  std::size_t total = 0;  // comparisons
  std::size_t ended = 0;  // comparisons that have ended; at most `total`
  // Comparisons that run, by their positions, which are below `total`, with their intervals so far.
  std::vector<std::pair<std::size_t, Progress>> running;
};

// One line of a batch's results (openapi.yaml, "BatchResult").
struct BatchLine {
  std::size_t position = 0;  // index of the comparison in the batch
  std::optional<End> end;    // nullopt: the service no longer has its result
};

// nullopt: not JSON, nested too deeply, or without the required members.
std::optional<nlohmann::ordered_json> document_from(std::string_view body);
std::optional<BatchState> batch_from(std::string_view body);
std::optional<BatchLine> batch_line_from(std::string_view line);

// Running time in milliseconds; nullopt: the comparison has none.
std::optional<double> run_ms(const nlohmann::ordered_json& comparison);

// Removes the member `view` and returns it: the path of the comparison's page, "/c/{id}". Empty if there is none of
// that form.
std::string take_view(nlohmann::ordered_json& comparison);

// SHA-256 of the mesh "a" or "b"; empty: none.
std::string sha256_of(const nlohmann::ordered_json& comparison, const char* part);

// Whether the comparison has the gate's direction, these limits to the last bit, what the gate expects, and its units.
// A service that does not convert units has no units.
bool is_answer_to(const nlohmann::ordered_json& comparison, const Gate& gate);

// Makes the gate's Error of a problem. `base`: address of the service, for messages. The message about a mesh is the
// same as if this process had measured.
Error error_of(const Problem& problem, const Gate& gate, const std::string& base);
// Makes the gate's Error of an unsuccessful reply.
Error error_of(const net::HttpAnswer& reply, const Gate& gate, const std::string& base, bool has_key);
Error not_a_service(const std::string& base, const std::string& what);

}  // namespace meshgauge::check::service
