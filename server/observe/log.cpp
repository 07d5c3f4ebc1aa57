#include "server/observe/log.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstdio>
#include <exception>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/utc.h"
#include "server/base/heap.h"
#include "server/observe/log_queue.h"

namespace meshgauge::server {
namespace {

bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; });
}

// Writes one line of JSON from front to back. It takes a quarter of the time of an nlohmann document, and the log has a
// line for every request.
class JsonLine {
 public:
  JsonLine() : text_("{") {}

  // Precondition of all: `name` needs no escapes. A text value may be any bytes: control characters are escaped, bytes
  // that are not UTF-8 are replaced.
  JsonLine& add(std::string_view name, std::string_view value) {
    begin(name);
    if (is_plain(value)) {
      text_.append("\"").append(value).append("\"");
    } else {
      text_ += nlohmann::json(value).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    }
    return *this;
  }
  JsonLine& add(std::string_view name, std::integral auto value) { return add_plain(name, std::to_string(value)); }
  JsonLine& add_bool(std::string_view name, bool value) { return add_plain(name, value ? "true" : "false"); }
  JsonLine& add_null(std::string_view name) { return add_plain(name, "null"); }

  // With three decimals; null if not finite.
  JsonLine& add_ms(std::string_view name, double ms) {
    if (!std::isfinite(ms)) return add_null(name);
    std::array<char, 400> text{};  // the largest double has 309 digits
    const int n = std::snprintf(text.data(), text.size(), "%.3f", ms);
    return add_plain(name, {text.data(), static_cast<std::size_t>(n)});
  }

  // Begins an object that close() ends.
  JsonLine& open(std::string_view name) {
    begin(name);
    text_ += '{';
    return *this;
  }
  JsonLine& close() {
    text_ += '}';
    return *this;
  }

  // The line, newline included.
  std::string finish() && {
    text_ += "}\n";
    return std::move(text_);
  }

 private:
  JsonLine& add_plain(std::string_view name, std::string_view value) {
    begin(name);
    text_ += value;
    return *this;
  }
  void begin(std::string_view name) {
    if (text_.back() != '{') text_ += ',';
    text_.append("\"").append(name).append("\":");
  }

  std::string text_;
};

std::atomic<std::uint64_t> lost_lines{0};

JsonLine begin(const std::string& event) {
  JsonLine line;
  line.add("time", api::to_utc_ms(std::chrono::system_clock::now())).add("event", event);
  return line;
}

std::string line_of(const std::string& event, const std::string& detail) {
  return std::move(begin(event).add("detail", detail)).finish();
}

std::string dropped_line(std::uint64_t lines) {
  return line_of("log", std::to_string(lines) + " lines were dropped: the reader of stderr was too slow");
}

std::string alike_line(std::uint64_t lines) {
  return line_of("refused", std::to_string(lines) + " further requests were refused (429, 503) in the last second");
}

constexpr std::chrono::seconds kAtExit{1};

// Not destroyed: threads that outlive main() may log.
LogQueue& queue() {
  static LogQueue& lines = *new LogQueue(STDERR_FILENO, dropped_line, alike_line);
  static const struct Drained {
    ~Drained() { lines.drain(kAtExit); }
  } drained;
  return lines;
}

// A line that no memory is left for is dropped: most lines tell of trouble, and must not become one.
template <class MakeLine>
void write_line(MakeLine make, bool alike = false) noexcept {
  const MayFail may_fail;
  try {
    if (alike) {
      queue().add_alike(make);
    } else {
      queue().add(make());
    }
  } catch (const std::exception&) {
    lost_lines.fetch_add(1, std::memory_order_relaxed);
  }
}

// A pipe takes writes of up to 4096 bytes (PIPE_BUF) in one piece.
std::string shortened(const std::string& text) {
  constexpr std::size_t kMostBytes = 256;
  return text.size() <= kMostBytes ? text : text.substr(0, kMostBytes) + "...";
}

void add_trace(JsonLine& line, const Trace& trace) {
  line.add("trace_id", trace.trace_id).add("span_id", trace.span_id);
  if (!trace.parent_id.empty()) line.add("parent_id", trace.parent_id);
}

std::string problem_type_of(const store::Job& row) {
  const auto problem = nlohmann::json::parse(row.problem, nullptr, false);
  return problem.is_object() ? problem.value("type", std::string()) : std::string();
}

void add_triangles(JsonLine& line, const MeshSizes& triangles) {
  line.open("triangles").add("a", triangles.a).add("b", triangles.b).close();
}

void add_stages(JsonLine& line, const std::vector<api::Stage>& stages) {
  line.open("stages_ms");
  for (const api::Stage& stage : stages) line.add_ms(stage.name, stage.ms);
  line.close();
}

// The trace is the client's, so that it continues from the front end that accepted the job to the worker that ran it.
std::string job_line(const store::Job& row, const std::optional<MeshSizes>& triangles,
                     const std::vector<api::Stage>& stages) {
  JsonLine line = begin("job");
  line.add("id", row.key.id);
  if (!row.key.owner.empty()) line.add("key", row.key.owner);
  if (!row.batch.empty()) line.add("batch", row.batch);
  line.add("state", to_string(row.state)).add("tries", row.tries);
  if (row.started && row.finished) {
    line.add_ms("duration_ms", static_cast<double>((*row.finished - *row.started).count()));
  }
  if (const auto trace = parse_traceparent(row.trace)) {
    line.add("trace_id", trace->trace_id).add("parent_id", trace->parent_id);
  }
  if (!row.problem.empty()) line.add("problem", problem_type_of(row));
  if (!row.verdict.empty()) line.add("verdict", row.verdict);
  if (triangles) add_triangles(line, *triangles);
  if (!stages.empty()) add_stages(line, stages);
  return std::move(line).finish();
}

}  // namespace

void start_log() { queue().start(); }

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
  if (const auto& triangles = exchange.triangles) add_triangles(line, *triangles);
  if (!exchange.stages.empty()) add_stages(line, exchange.stages);
  return std::move(line).finish();
}

// Under overload most lines would tell of the same refusal.
void log_request(const Exchange& exchange, double seconds) {
  static const std::string overloaded = api::Problem{api::ProblemKind::overloaded, ""}.type();
  static const std::string too_many = api::Problem{api::ProblemKind::too_many_requests, ""}.type();
  const bool alike = exchange.failure.empty() && (exchange.problem == overloaded || exchange.problem == too_many);
  write_line([&] { return request_line(exchange, seconds); }, alike);
}

void log_job(const store::Job& row, const std::optional<MeshSizes>& triangles, const std::vector<api::Stage>& stages) {
  write_line([&] { return job_line(row, triangles, stages); });
}

void log_listening(const std::string& address, const std::string& simd) {
  write_line([&] { return std::move(begin("listening").add("detail", address).add("simd", simd)).finish(); });
}

void log_event(const std::string& event, const std::string& detail) {
  write_line([&] { return line_of(event, detail); });
}

std::uint64_t log_lines_dropped() { return queue().dropped() + lost_lines.load(std::memory_order_relaxed); }

}  // namespace meshgauge::server
