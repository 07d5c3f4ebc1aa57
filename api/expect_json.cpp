#include <nlohmann/json.hpp>

#include "api/expectations.h"
#include "api/gate.h"

namespace meshgauge::api {
namespace {

nlohmann::ordered_json span_of(const Span& span) {
  auto json = nlohmann::ordered_json::object();
  if (span.min) json["min"] = *span.min;
  if (span.max) json["max"] = *span.max;
  return json;
}

nlohmann::ordered_json count_of(const Span& span) {
  auto json = span.min && span.min == span.max ? nlohmann::ordered_json(*span.min) : span_of(span);
  for (auto& end : json) end = static_cast<std::uint64_t>(end.get<double>());  // in kCountRange, of whole numbers
  return json;
}

}  // namespace

nlohmann::ordered_json json_of(const std::vector<Expectation>& expectations) {
  auto json = nlohmann::ordered_json::array();
  for (const Expectation& one : expectations)
    json.push_back(
        {{"name", one.name}, {"verdict", to_string(one.verdict)}, {"found", one.found}, {"expected", one.expected}});
  return json;
}

nlohmann::ordered_json json_of(const Expectations& expect) {
  auto json = nlohmann::ordered_json::object();
  if (expect.watertight) json["watertight"] = *expect.watertight;
  if (expect.oriented) json["oriented"] = *expect.oriented;
  if (expect.triangles) json["triangles"] = count_of(*expect.triangles);
  if (expect.degenerate) json["degenerate"] = count_of(*expect.degenerate);
  if (expect.components) json["components"] = count_of(*expect.components);
  if (expect.volume) json["volume"] = span_of(*expect.volume);
  if (expect.volume_within) json["volume"]["within"] = *expect.volume_within;
  return json;
}

}  // namespace meshgauge::api
