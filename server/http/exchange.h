// One request and its response: the argument of every handler, and the source of the request's log line and metrics.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/problem.h"
#include "api/result/response.h"
#include "server/http/body.h"
#include "server/http/head.h"
#include "server/http/head_values.h"

namespace meshgauge::server {

using Clock = std::chrono::steady_clock;

struct MeshSizes {
  std::size_t a = 0;
  std::size_t b = 0;
};

// W3C Trace Context, level 1: links a request to its client's distributed trace.
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

inline constexpr int kNoContent = 204;
inline constexpr int kNotModified = 304;
// RFC 9110 sections 8.6 and 15.4.5.
inline bool has_content(int status) { return status != kNoContent && status != kNotModified; }

// Nothing is wrong with the request: the client may send it again.
inline bool may_retry(int status) { return status == 429 || status == 503; }

// Bytes, and the object that keeps them alive.
struct FileBody {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> holder;
};

struct Exchange;

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  // all but Content-Type and Content-Length
  // Instead of `body`. Makes the response when what it waits for has happened: returns nullopt when the response is
  // set, else when to call it again. It is also called after exchange.wake(), and when exchange.client_gone has become
  // true. May throw.
  std::function<std::optional<Clock::time_point>(Exchange&)> later = nullptr;
  // Instead of `body`: chunks over time. Appends the next piece to `piece`, or leaves it empty; returns nullopt after
  // the last piece, else when to call it again. Also called after exchange.wake(), but not before the client has taken
  // the piece before. May throw; the response then breaks off without a terminating chunk.
  std::function<std::optional<Clock::time_point>(std::string& piece)> stream = nullptr;
  bool quick = false;                           // `later` and `stream` never block: the event loop calls them itself
  std::optional<FileBody> file = std::nullopt;  // instead of `body`
  bool length_known = true;                     // false: a response to HEAD has no Content-Length
};

struct Exchange {
  Exchange(std::string unique_id, const Head& request_head, Body& request_body)
      : id(std::move(unique_id)),
        head(request_head),
        body(request_body),
        trace(continue_trace(request_head)),
        preferences(read_preferences(request_head)),
        idempotency_key(read_idempotency_key(request_head)) {}

  std::string id;       // random, 128 bits; also the id of a comparison that this request creates
  std::string peer;     // the address_tag() of the client
  std::string owner;    // id of the client's key; empty: the service runs without keys
  std::string route;    // the router's template; empty: none matched
  std::string segment;  // the part of the path that matched {} in the template
  const std::function<void(Exchange&)>* action = nullptr;  // of the route; null: none, or refused
  const Head& head;
  Body& body;
  const Trace trace;  // the client's trace, or a new one
  const Preferences preferences;
  const IdempotencyKey idempotency_key;
  std::function<void()> wake;  // see Response::later. Thread safe; may outlive the exchange
  bool client_gone = false;    // the client has closed its side of the connection
  Response response;

  // For the log and the metrics.
  Clock::time_point started = Clock::now();  // when the head was complete
  std::uint64_t bytes_out = 0;               // written, head included
  bool delivered = false;                    // the kernel has taken the response to its last byte
  std::string problem;                       // problem type of the response; empty: no problem
  std::string failure;                       // text of an exception, for the log; never sent
  std::vector<api::Stage> stages;
  std::optional<MeshSizes> triangles;
};

// The client that shares are counted for: the owner; without keys, the peer.
inline const std::string& client_of(const Exchange& exchange) {
  return exchange.owner.empty() ? exchange.peer : exchange.owner;
}

// Sets the response to a document.
void answer_with(Exchange& exchange, std::string document, int status = 200, const char* type = "application/json");

// Sets the response to a problem document, whatever it was before. With status 429 or 503 it gets Retry-After: 1 s, or
// `retry_after` rounded up to whole seconds, 1 to 60.
void answer(Exchange& exchange, const api::Problem& problem,
            std::chrono::milliseconds retry_after = std::chrono::seconds(1));

// A problem that was serialized before.
struct ProblemDocument {
  int status = 500;
  std::string type;
  std::string json;
};
ProblemDocument document_of(const api::Problem& problem);
void answer(Exchange& exchange, ProblemDocument document, std::chrono::milliseconds retry_after);

// Returns a server-sent event (text/event-stream) as text, for Response::stream. Precondition: `data` is one line.
std::string event(std::string_view name, std::string_view data);

// Adds `header` to the response's Vary.
void add_vary(Response& response, const std::string& header);

// Adds the headers of every response: nosniff, no-store, no-referrer, and for HTML a policy that loads and runs
// nothing. Headers that the handler has set stay.
void add_security_headers(Response& response);

}  // namespace meshgauge::server
