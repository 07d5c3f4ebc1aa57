#include "server/http/exchange.h"

#include <algorithm>

#include "api/base/digest.h"
#include "api/base/text.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kTraceParentBytes = 55;  // 00-<32>-<16>-<2>
constexpr std::size_t kMostStateBytes = 512;   // the length that implementations must support; more is dropped

bool is_zero(std::string_view text) { return text.find_first_not_of('0') == std::string_view::npos; }

// All values of the header, joined as in RFC 9110 section 5.3.
std::string joined(const Head& head, std::string_view name) {
  std::string all;
  for (const auto& [key, value] : head.headers) {
    if (key == name) all.append(all.empty() ? "" : ",").append(value);
  }
  return all;
}

// True if it may be passed on: at most 512 bytes of printable ASCII with a '='. Its members are not parsed.
bool is_tracestate(std::string_view value) {
  return value.find('=') != std::string_view::npos && value.size() <= kMostStateBytes &&
         std::all_of(value.begin(), value.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

void add_missing(Response& response, const char* name, const char* value) {
  const bool there = std::any_of(response.headers.begin(), response.headers.end(),
                                 [&](const auto& header) { return header.first == name; });
  if (!there) response.headers.emplace_back(name, value);
}

}  // namespace

std::optional<TraceParent> parse_traceparent(std::string_view value) {
  if (value.size() < kTraceParentBytes) return std::nullopt;
  if (value[2] != '-' || value[35] != '-' || value[52] != '-') return std::nullopt;
  const std::string_view version = value.substr(0, 2), trace_id = value.substr(3, 32), parent_id = value.substr(36, 16),
                         flags = value.substr(53, 2);
  for (const std::string_view field : {version, trace_id, parent_id, flags}) {
    if (!api::is_lower_hex(field, field.size())) return std::nullopt;
  }
  if (version == "ff" || is_zero(trace_id) || is_zero(parent_id)) return std::nullopt;
  // A later version may add fields after another dash; version 00 has none.
  if (value.size() > kTraceParentBytes && (version == "00" || value[kTraceParentBytes] != '-')) return std::nullopt;
  const bool odd = std::string_view("13579bdf").find(flags[1]) != std::string_view::npos;
  return TraceParent{trace_id, parent_id, odd};
}

Trace continue_trace(const Head& head) {
  Trace trace;
  trace.span_id = api::random_id().substr(0, 16);
  if (is_zero(trace.span_id)) trace.span_id.back() = '1';
  const std::string header = joined(head, "traceparent");
  if (const auto parent = parse_traceparent(header); parent && header == head.header("traceparent")) {
    trace.trace_id = parent->trace_id;
    trace.parent_id = parent->parent_id;
    trace.sampled = parent->sampled;
    const std::string state = joined(head, "tracestate");
    if (is_tracestate(state)) trace.state = state;
    return trace;
  }
  trace.trace_id = api::random_id();
  if (is_zero(trace.trace_id)) trace.trace_id.back() = '1';
  return trace;
}

std::string traceparent(const Trace& trace) {
  return "00-" + trace.trace_id + "-" + trace.span_id + (trace.sampled ? "-01" : "-00");
}

std::vector<std::pair<std::string, std::string>> trace_headers(const Trace& trace) {
  std::vector<std::pair<std::string, std::string>> headers{{"traceparent", traceparent(trace)}};
  if (!trace.state.empty()) headers.emplace_back("tracestate", trace.state);
  return headers;
}

void answer_with(Exchange& exchange, std::string document, int status, const char* type) {
  exchange.response.status = status;
  exchange.response.content_type = type;
  exchange.response.body = std::move(document);
}

void answer(Exchange& exchange, const api::Problem& problem, std::chrono::milliseconds retry_after) {
  answer(exchange, document_of(problem), retry_after);
}

ProblemDocument document_of(const api::Problem& problem) {
  return {problem.status(), problem.type(), to_json(problem)};
}

void answer(Exchange& exchange, ProblemDocument document, std::chrono::milliseconds retry_after) {
  Response& response = exchange.response;
  response.later = nullptr;
  response.stream = nullptr;
  response.file.reset();
  response.length_known = true;
  response.status = document.status;
  response.content_type = "application/problem+json";
  response.body = std::move(document.json);
  if (may_retry(document.status)) {
    const auto seconds = std::clamp<std::int64_t>(std::chrono::ceil<std::chrono::seconds>(retry_after).count(), 1, 60);
    response.headers.emplace_back("Retry-After", std::to_string(seconds));
  }
  exchange.problem = std::move(document.type);
}

std::string event(std::string_view name, std::string_view data) {
  return "event: " + std::string(name) + "\ndata: " + std::string(data) + "\n\n";
}

void add_vary(Response& response, const std::string& header) {
  for (auto& [name, value] : response.headers) {
    if (name != "Vary") continue;
    value += ", " + header;
    return;
  }
  response.headers.emplace_back("Vary", header);
}

void add_security_headers(Response& response) {
  add_missing(response, "X-Content-Type-Options", "nosniff");
  add_missing(response, "Cache-Control", "no-store");
  add_missing(response, "Referrer-Policy", "no-referrer");
  if (!response.content_type.starts_with("text/html")) return;
  add_missing(response, "Content-Security-Policy",
              "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
}

}  // namespace meshgauge::server
