#include "server/log.h"

#include <unistd.h>

#include <array>
#include <ctime>
#include <utility>

#include "server/observe/json_line.h"

namespace meshgauge::server {
namespace {

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

JsonLine begin(const std::string& event) {
  JsonLine line;
  line.add("time", utc_now()).add("event", event);
  return line;
}

// One write a line, so that the lines of several threads do not mix.
void write_line(const std::string& line) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
}

// A pipe takes lines of up to 4096 bytes in one piece.
std::string shortened(const std::string& text) {
  constexpr std::size_t kMostBytes = 256;
  return text.size() <= kMostBytes ? text : text.substr(0, kMostBytes) + "...";
}

void add_trace(JsonLine& line, const Trace& trace) {
  line.add("trace_id", trace.trace_id).add("span_id", trace.span_id);
  if (!trace.parent_id.empty()) line.add("parent_id", trace.parent_id);
}

void add_stages(JsonLine& line, const std::vector<api::Stage>& stages) {
  line.open("stages_ms");
  for (const api::Stage& stage : stages) line.add_ms(stage.name, stage.ms);
  line.close();
}

}  // namespace

std::string request_line(const Exchange& exchange, double seconds) {
  JsonLine line = begin("request");
  line.add("id", exchange.id);
  if (!exchange.owner.empty()) line.add("key", exchange.owner);
  line.add("method", shortened(exchange.head.method)).add("path", shortened(exchange.head.path));
  exchange.route.empty() ? line.add_null("route") : line.add("route", exchange.route);
  line.add("status", exchange.response.status)
      .add("bytes_in", exchange.body.bytes())
      .add("bytes_out", exchange.bytes_out)
      .add_ms("duration_ms", seconds * 1000);
  add_trace(line, exchange.trace);
  if (!exchange.delivered) line.add_bool("delivered", false);
  if (!exchange.problem.empty()) line.add("problem", exchange.problem);
  if (!exchange.failure.empty()) line.add("failure", shortened(exchange.failure));
  if (const auto& triangles = exchange.triangles) {
    line.open("triangles").add("a", triangles->a).add("b", triangles->b).close();
  }
  if (!exchange.stages.empty()) add_stages(line, exchange.stages);
  return std::move(line).finish();
}

void log_request(const Exchange& exchange, double seconds) { write_line(request_line(exchange, seconds)); }

void log_listening(const std::string& address, const std::string& simd) {
  write_line(std::move(begin("listening").add("detail", address).add("simd", simd)).finish());
}

void log_event(const std::string& event, const std::string& detail) {
  write_line(std::move(begin(event).add("detail", detail)).finish());
}

}  // namespace meshgauge::server
