// The line of a request: its members, and that no text from a client can end it.
#include "server/observe/log.h"

#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/result/response.h"
using namespace meshgauge;
using namespace meshgauge::server;
using nlohmann::json;

namespace {

struct LogClient {
  Connection connection{-1};
  Head head;
  Body body{connection, head, 0};
};

// The parsed line, which is exactly one.
json line_of(const Exchange& exchange) {
  const std::string line = request_line(exchange, 0.0125);
  CHECK(line.size() < 4096);
  CHECK(line.find('\n') == line.size() - 1);
  for (const char c : line.substr(0, line.size() - 1)) CHECK(static_cast<unsigned char>(c) >= 0x20);
  return json::parse(line);
}

}  // namespace

TEST_CASE("log: a comparison's line has its sizes, its stages and its trace") {
  LogClient client;
  client.head.method = "POST";
  client.head.path = "/v1/comparisons";
  client.head.headers = {{"traceparent", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"}};
  Exchange exchange("0123", client.head, client.body);
  exchange.route = "/v1/comparisons";
  exchange.owner = "ci";
  exchange.bytes_out = 1234;
  exchange.delivered = true;
  exchange.triangles = MeshSizes{10, 20};
  api::Comparison comparison;
  comparison.times.total = 7.5;
  exchange.stages = api::stages(comparison);
  const json line = line_of(exchange);
  CHECK(line["event"] == "request");
  CHECK(line["id"] == "0123");
  CHECK(line["key"] == "ci");
  CHECK(line["method"] == "POST");
  CHECK(line["path"] == "/v1/comparisons");
  CHECK(line["route"] == "/v1/comparisons");
  CHECK(line["status"] == 200);
  CHECK(line["bytes_in"] == 0);
  CHECK(line["bytes_out"] == 1234);
  CHECK(line["duration_ms"] == 12.5);
  CHECK(line["triangles"] == json{{"a", 10}, {"b", 20}});
  CHECK(line["stages_ms"]["total"] == 7.5);
  CHECK(line["stages_ms"].size() == 8);
  CHECK(line["trace_id"] == "4bf92f3577b34da6a3ce929d0e0e4736");
  CHECK(line["parent_id"] == "00f067aa0ba902b7");
  CHECK(line["span_id"] == exchange.trace.span_id);
  CHECK(!line.contains("problem"));
  CHECK(!line.contains("delivered"));
}

TEST_CASE("log: text from a client stays one short line") {
  LogClient client;
  client.head.method = "GET\r\n{\"event\":\"forged\"}";
  client.head.path = "/\n\x1b[31m\xff\"" + std::string(5000, '"');
  Exchange exchange("0123", client.head, client.body);
  exchange.failure = std::string(5000, '\x01');
  answer(exchange, {api::ProblemKind::not_found, "", {}});
  const json line = line_of(exchange);
  CHECK(line["event"] == "request");
  CHECK(line["route"] == nullptr);
  CHECK(line["delivered"] == false);
  CHECK(line["problem"] == "/problems/not-found");
  CHECK(line["path"].get<std::string>().ends_with("..."));
}
