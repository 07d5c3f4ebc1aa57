// One request and its response: the argument of every handler, and the source of the request's log line and metrics.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/compare.h"
#include "api/problem.h"
#include "api/response.h"
#include "server/http/body.h"
#include "server/http/connection.h"
#include "server/http/head.h"
#include "server/observe/trace.h"

namespace meshgauge::server {

struct MeshSizes {
  std::size_t a = 0;
  std::size_t b = 0;
};

inline constexpr int kNoContent = 204;
inline constexpr int kNotModified = 304;
// RFC 9110 sections 8.6 and 15.4.5.
inline bool has_content(int status) { return status != kNoContent && status != kNotModified; }

// Bytes, and the object that keeps them alive.
struct FileBody {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> holder;
};

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  // all but Content-Type and Content-Length
  // Instead of `body` (server/http/event_stream.h). Appends the next piece to `piece`, or leaves it empty when there is
  // none within 100 ms; returns false after the last piece. Called on the connection's thread. May throw.
  std::function<bool(std::string& piece)> stream = nullptr;
  std::optional<FileBody> file = std::nullopt;  // instead of `body` (server/http/file_body.h)
  bool length_known = true;                     // false: a response to HEAD has no Content-Length
};

struct Exchange {
  Exchange(std::string unique_id, const Head& request_head, Body& request_body, Connection& client)
      : id(std::move(unique_id)),
        head(request_head),
        body(request_body),
        connection(client),
        trace(continue_trace(request_head)) {}

  std::string id;       // random, 128 bits; also the id of a comparison that this request creates
  std::string owner;    // id of the client's key; empty: the service runs without keys
  std::string route;    // the router's template; empty: none matched
  std::string segment;  // the part of the path that matched {} in the template
  const Head& head;
  Body& body;
  Connection& connection;
  const Trace trace;  // the client's trace, or a new one
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

// Sets the response to a problem document, whatever it was before. With status 429 or 503 it gets Retry-After: 1 s, or
// `retry_after` rounded up to whole seconds, 1 to 60.
void answer(Exchange& exchange, const api::Problem& problem);
void answer(Exchange& exchange, const api::Problem& problem, std::chrono::milliseconds retry_after);

// A problem that was serialized before.
struct ProblemDocument {
  int status = 500;
  std::string type;
  std::string json;
};
void answer(Exchange& exchange, ProblemDocument document, std::chrono::milliseconds retry_after);

// Returns a problem if the request has a query; nullopt: it has none. For paths without query parameters: a misplaced
// option must not be ignored silently.
std::optional<api::Problem> refuse_query(const Exchange& exchange);

// Adds `header` to the response's Vary.
void add_vary(Response& response, const std::string& header);

// Adds the headers of every response: nosniff, no-store, no-referrer, and for HTML a policy that loads and runs
// nothing. Headers that the handler has set stay.
void add_security_headers(Response& response);

}  // namespace meshgauge::server
