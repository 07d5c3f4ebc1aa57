#include "server/log.h"

#include <unistd.h>

#include <array>
#include <cmath>
#include <ctime>

#include <nlohmann/json.hpp>

namespace meshgauge::server {
namespace {

using Json = nlohmann::ordered_json;

std::string utc_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  std::tm parts{};
  gmtime_r(&now.tv_sec, &parts);
  std::array<char, 40> text{};
  const std::size_t n = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text.data() + n, text.size() - n, ".%03ldZ", now.tv_nsec / 1'000'000);
  return text.data();
}

std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n"; }

// One write a line, so that the lines of several threads do not mix.
void write_line(const std::string& line) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
}

// A pipe takes lines of up to 4096 bytes in one piece.
std::string shortened(const std::string& text) {
  constexpr std::size_t kMostBytes = 256;
  return text.size() <= kMostBytes ? text : text.substr(0, kMostBytes) + "...";
}

// More digits say nothing, and take longer to write.
double to_microseconds(double ms) { return std::round(ms * 1000) / 1000; }

void add_trace(Json& json, const Trace& trace) {
  json["trace_id"] = trace.trace_id;
  json["span_id"] = trace.span_id;
  if (!trace.parent_id.empty()) json["parent_id"] = trace.parent_id;
}

void add_stages(Json& json, const std::vector<api::Stage>& stages) {
  Json& times = json["stages_ms"];
  for (const api::Stage& stage : stages) times[stage.name] = to_microseconds(stage.ms);
}

}  // namespace

std::string request_line(const Exchange& exchange, double seconds) {
  Json json{{"time", utc_now()},
            {"event", "request"},
            {"id", exchange.id},
            {"method", shortened(exchange.head.method)},
            {"path", shortened(exchange.head.path)},
            {"route", exchange.route.empty() ? Json(nullptr) : Json(exchange.route)},
            {"status", exchange.response.status},
            {"bytes_in", exchange.body.bytes()},
            {"bytes_out", exchange.bytes_out},
            {"duration_ms", to_microseconds(seconds * 1000)}};
  add_trace(json, exchange.trace);
  if (!exchange.owner.empty()) json["key"] = exchange.owner;
  if (!exchange.delivered) json["delivered"] = false;
  if (!exchange.problem.empty()) json["problem"] = exchange.problem;
  if (!exchange.failure.empty()) json["failure"] = shortened(exchange.failure);
  if (exchange.triangles) json["triangles"] = {{"a", exchange.triangles->a}, {"b", exchange.triangles->b}};
  if (!exchange.stages.empty()) add_stages(json, exchange.stages);
  return line_of(json);
}

void log_request(const Exchange& exchange, double seconds) { write_line(request_line(exchange, seconds)); }

void log_listening(const std::string& address, const std::string& simd) {
  write_line(line_of({{"time", utc_now()}, {"event", "listening"}, {"detail", address}, {"simd", simd}}));
}

void log_event(const std::string& event, const std::string& detail) {
  write_line(line_of({{"time", utc_now()}, {"event", event}, {"detail", detail}}));
}

}  // namespace meshgauge::server
