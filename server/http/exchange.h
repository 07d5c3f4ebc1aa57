// One request and what becomes of it: what a handler is given, and what the log line tells.
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

// Bytes, and what keeps them.
struct FileBody {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> holder;
};

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  // more than Content-Type and Content-Length
  // Instead of a body: appends the next piece, if there is one within 100 ms, and says whether there are more to come.
  // Called on the connection's thread until then, or until the client is gone.
  std::function<bool(std::string& piece)> stream = nullptr;
  std::optional<FileBody> file = std::nullopt;  // instead of a body (server/http/file_body.h)
  bool length_known = true;                     // else an answer to HEAD says none
};

struct Exchange {
  Exchange(std::string unique_id, const Head& request_head, Body& request_body, Connection& client)
      : id(std::move(unique_id)),
        head(request_head),
        body(request_body),
        connection(client),
        trace(continue_trace(request_head)) {}

  std::string id;       // unguessable; also the id of a comparison that it begins
  std::string owner;    // the id of the key that asks; empty: no key, everything stored under it is everybody's
  std::string route;    // the router's template; empty: none matched
  std::string segment;  // what stands for the {} of the route
  const Head& head;
  Body& body;
  Connection& connection;
  const Trace trace;  // the caller's, or one that begins here
  Response response;

  // For the log and the metrics.
  Clock::time_point started = Clock::now();  // the head is there
  std::uint64_t bytes_out = 0;               // written, head included
  bool delivered = false;                    // to its last byte, as far as the kernel knows
  std::string problem;                       // type; empty for a result
  std::string failure;                       // what an exception said; never sent
  std::vector<api::Stage> stages;
  std::optional<MeshSizes> triangles;
};

// Makes the answer of this exchange a problem document. A 503 says to come again in a second.
void answer(Exchange& exchange, const api::Problem& problem);
// ... or in so long.
void answer(Exchange& exchange, const api::Problem& problem, std::chrono::milliseconds retry_after);

// A problem as it was written down before.
struct ProblemDocument {
  int status = 500;
  std::string type;
  std::string json;
};
void answer(Exchange& exchange, ProblemDocument document, std::chrono::milliseconds retry_after);

// Refuses a query where none means anything: an option that is misspelt or misplaced must not pass unnoticed.
std::optional<api::Problem> refuse_query(const Exchange& exchange);

// Says that the answer depends on a header of the request, beside those that were said before.
void add_vary(Response& response, const std::string& header);

// What every answer tells a browser: not to guess types, not to keep it, and, of a page that says nothing else, to load
// and to run nothing. A header that is there already stays.
void add_security_headers(Response& response);

}  // namespace meshgauge::server
