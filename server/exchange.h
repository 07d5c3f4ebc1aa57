// One request and what becomes of it: what a handler is given, and what the log line tells.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/compare.h"
#include "api/problem.h"
#include "server/body.h"
#include "server/connection.h"
#include "server/head.h"

namespace meshgauge::server {

struct MeshSizes {
  std::size_t a = 0;
  std::size_t b = 0;
};

inline constexpr int kNoContent = 204;

struct Response {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  // more than Content-Type and Content-Length
};

struct Exchange {
  Exchange(std::string unique_id, const Head& request_head, Body& request_body, Connection& client)
      : id(std::move(unique_id)), head(request_head), body(request_body), connection(client) {}

  std::string id;     // unguessable; also the id of the result
  std::string owner;  // the id of the key that asks; empty: no key, everything stored under it is everybody's
  const Head& head;
  Body& body;
  Connection& connection;
  Response response;

  // For the log.
  std::string problem;  // type; empty for a result
  std::string failure;  // what an exception said; never sent
  std::string stages;   // as in Server-Timing
  std::optional<MeshSizes> triangles;
};

// Makes the answer of this exchange a problem document.
void answer(Exchange& exchange, const api::Problem& problem);

// What every answer tells a browser: not to guess types, not to keep it, and, of a page that says nothing else, to load
// and to run nothing. A header that is there already stays.
void add_security_headers(Response& response);

}  // namespace meshgauge::server
