// One request and what becomes of it: what a handler is given, and what the log line tells.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/compare.h"
#include "api/problem.h"
#include "api/response.h"
#include "server/body.h"
#include "server/connection.h"
#include "server/head.h"
#include "server/observe/trace.h"

namespace meshgauge::server {

struct MeshSizes {
  std::size_t a = 0;
  std::size_t b = 0;
};

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  // more than Content-Type and Content-Length
};

struct Exchange {
  Exchange(std::string unique_id, const Head& request_head, Body& request_body, Connection& client)
      : id(std::move(unique_id)),
        head(request_head),
        body(request_body),
        connection(client),
        trace(take_up(request_head)) {}

  std::string id;  // unguessable; also the id of the result
  const Head& head;
  Body& body;
  Connection& connection;
  const Trace trace;  // the caller's, or one that begins here
  Response response;

  // For the log and the metrics.
  Clock::time_point started = Clock::now();  // the head is there
  std::string owner;                         // the id of the bearer key; empty: none
  std::string route;                         // the router's template; empty: none matched
  std::uint64_t bytes_out = 0;               // written, head included
  bool delivered = false;                    // to its last byte, as far as the kernel knows
  std::string problem;                       // type; empty for a result
  std::string failure;                       // what an exception said; never sent
  std::vector<api::Stage> stages;
  std::optional<MeshSizes> triangles;
};

// Makes the answer of this exchange a problem document.
void answer(Exchange& exchange, const api::Problem& problem);

// What the log tells of a comparison.
void note(Exchange& exchange, const api::Comparison& comparison);

}  // namespace meshgauge::server
