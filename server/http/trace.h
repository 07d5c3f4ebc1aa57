// W3C Trace Context, level 1: links a request to its client's distributed trace.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/head.h"

namespace meshgauge::server {

struct Trace {
  std::string trace_id;   // 32 lower-case hex digits, not all zero
  std::string parent_id;  // the client's span, 16 hex digits; empty: the trace starts here
  std::string span_id;    // this request's span
  bool sampled = false;   // the client records this trace
  std::string state;      // tracestate, passed on unchanged; empty: none
};

// Returns the trace of the request's traceparent and tracestate, with a new span. If traceparent is missing, invalid or
// sent twice: a new trace, and tracestate is ignored. Throws if no random numbers are available.
Trace continue_trace(const Head& head);

// Returns the value of a traceparent header: version 00, with span_id as the parent.
std::string traceparent(const Trace& trace);

// Returns the headers that pass the trace on: traceparent, and tracestate if there is one.
std::vector<std::pair<std::string, std::string>> trace_headers(const Trace& trace);

struct TraceParent {
  std::string_view trace_id;
  std::string_view parent_id;
  bool sampled = false;
};
std::optional<TraceParent> parse_traceparent(std::string_view value);  // nullopt: invalid
// True if it may be passed on: at most 512 bytes of printable ASCII with a '='. Its members are not parsed.
bool is_tracestate(std::string_view value);

}  // namespace meshgauge::server
