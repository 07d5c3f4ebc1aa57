// W3C Trace Context, level 1: which trace of the caller's a request belongs to.
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
  std::string parent_id;  // the caller's span, 16 of them; empty: the trace begins here
  std::string span_id;    // ours
  bool sampled = false;   // the caller records this trace
  std::string state;      // tracestate, to be passed on as it came; empty: none
};

// The trace that the head's traceparent and tracestate name, with a new span for us. A traceparent that is missing, not
// valid or there twice begins a new trace, and its tracestate is not looked at. Throws when there are no random
// numbers.
Trace continue_trace(const Head& head);

// The value of the header: version 00, our span as the parent.
std::string traceparent(const Trace& trace);

// The headers that hand the trace on.
std::vector<std::pair<std::string, std::string>> trace_headers(const Trace& trace);

// What continue_trace() is made of.
struct TraceParent {
  std::string_view trace_id;
  std::string_view parent_id;
  bool sampled = false;
};
std::optional<TraceParent> parse_traceparent(std::string_view value);
// Whether it is passed on: at most 512 bytes of printable ASCII. Its members are not looked at.
bool is_tracestate(std::string_view value);

}  // namespace meshgauge::server
