#include "server/http/origins.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::Cors;
using server::Head;
using server::OriginCheck;
using Hosts = OriginCheck::Hosts;

namespace {

bool refused(const OriginCheck& check, const std::string& method, const std::string& host,
             const std::string& origin = "") {
  Head head;
  head.method = method;
  if (!host.empty()) head.headers.emplace_back("host", host);
  if (!origin.empty()) head.headers.emplace_back("origin", origin);
  const auto refusal = check.find_refusal(head);
  if (refusal) CHECK(refusal->kind == api::ProblemKind::foreign_request);
  return refusal.has_value();
}

}  // namespace

TEST_CASE("origin check: requests to other names are refused") {
  const auto check = OriginCheck::parse("gauge.example, gauge-2.lan", Hosts::listed, {}).value();
  for (const char* own : {"localhost", "localhost:8080", "LocalHost:1", "127.0.0.1:8080", "[::1]:8080", "192.168.1.5",
                          "gauge.example", "Gauge.Example:443", "gauge-2.lan:80", ""}) {
    CHECK_MESSAGE(!refused(check, "DELETE", own), own);
  }
  for (const char* foreign :
       {"attacker.example", "attacker.example:8080", "localhost.attacker.example", "127.0.0.1.attacker.example",
        "gauge.example.attacker.example", "x@localhost", "a", "[::1].attacker.example", "[::1]attacker.example",
        "localhost:x.attacker.example", "127.0.0.1:80.attacker.example", "[::1", "127.0.0.256", ":80"}) {
    CHECK_MESSAGE(refused(check, "GET", foreign), foreign);
    CHECK_MESSAGE(refused(check, "POST", foreign), foreign);
  }
}

TEST_CASE("origin check: a page of another site changes nothing") {
  const auto check = OriginCheck::parse("", Hosts::listed, Cors::parse("https://viewer.example").value()).value();
  for (const char* method : {"POST", "PUT", "DELETE"}) {
    CHECK(!refused(check, method, "localhost:8080"));
    CHECK(!refused(check, method, "localhost:8080", "http://localhost:8080"));
    CHECK(!refused(check, method, "LOCALHOST:8080", "https://localhost:8080"));
    CHECK(!refused(check, method, "[::1]:8080", "http://[::1]:8080"));
    CHECK(!refused(check, method, "localhost:8080", "https://viewer.example"));
    for (const char* foreign : {"https://attacker.example", "http://localhost:3000", "http://localhost", "null",
                                "http://127.0.0.1:8080", "https://viewer.example.attacker.example", "localhost:8080"}) {
      CHECK_MESSAGE(refused(check, method, "localhost:8080", foreign), foreign);
    }
  }
  CHECK(!refused(check, "GET", "localhost:8080", "https://attacker.example"));  // which CORS keeps from reading it
  CHECK(refused(check, "POST", "", "https://attacker.example"));
}

TEST_CASE("origin check: a public service without a list has any name, and one with a list has those") {
  const auto any = OriginCheck::parse("", Hosts::any, {}).value();
  CHECK(!refused(any, "POST", "gauge.example", "https://gauge.example"));
  CHECK(refused(any, "POST", "gauge.example", "https://attacker.example"));
  const auto listed = OriginCheck::parse("localhost", Hosts::any, {}).value();
  CHECK(!refused(listed, "POST", "localhost:8080"));
  CHECK(refused(listed, "POST", "gauge.example"));
}

TEST_CASE("origin check: with keys nothing is refused, and a list of other things is an error") {
  CHECK(!refused(OriginCheck(), "POST", "attacker.example", "https://attacker.example"));
  for (const char* wrong :
       {"http://gauge.example", "gauge.example:8080", "*", "*.example", "A.example", "a,,b", "a/b"}) {
    CHECK_MESSAGE(!OriginCheck::parse(wrong, Hosts::listed, {}).ok(), wrong);
  }
}
