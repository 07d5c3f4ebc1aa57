#include "server/http/exchange.h"

#include <string>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge::server;

namespace {

const std::string kTraceId = "4bf92f3577b34da6a3ce929d0e0e4736";
const std::string kParentId = "00f067aa0ba902b7";
const std::string kValid = "00-" + kTraceId + "-" + kParentId + "-01";

Head head_with(std::vector<std::pair<std::string, std::string>> headers) {
  Head head;
  head.headers = std::move(headers);
  return head;
}

bool is_hex(const std::string& text, std::size_t size) {
  return text.size() == size && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::string with(std::size_t at, char c) {
  std::string value = kValid;
  value[at] = c;
  return value;
}

}  // namespace

TEST_CASE("trace: a valid traceparent gives its fields") {
  const auto parent = parse_traceparent(kValid);
  REQUIRE(parent);
  CHECK(parent->trace_id == kTraceId);
  CHECK(parent->parent_id == kParentId);
  CHECK(parent->sampled);
  CHECK(!parse_traceparent(kValid.substr(0, 53) + "00")->sampled);
  // Unknown flags are ignored.
  CHECK(!parse_traceparent(kValid.substr(0, 53) + "fe")->sampled);
  CHECK(parse_traceparent(kValid.substr(0, 53) + "ff")->sampled);
}

TEST_CASE("trace: malformed headers of version 00 are refused") {
  CHECK(!parse_traceparent(""));
  for (std::size_t n = 0; n < kValid.size(); ++n) CHECK(!parse_traceparent(kValid.substr(0, n)));
  for (std::size_t at = 0; at < kValid.size(); ++at) {
    for (const char c : {'g', 'A', ' ', '\0', '_', '\xff'}) CHECK(!parse_traceparent(with(at, c)));
  }
  CHECK(!parse_traceparent(kValid + "-"));
  CHECK(!parse_traceparent(kValid + "-extra"));
  CHECK(!parse_traceparent(" " + kValid));
  CHECK(!parse_traceparent("00-" + std::string(32, '0') + "-" + kParentId + "-01"));
  CHECK(!parse_traceparent("00-" + kTraceId + "-" + std::string(16, '0') + "-01"));
  CHECK(!parse_traceparent("ff" + kValid.substr(2)));
}

TEST_CASE("trace: the known fields of a later version are read") {
  const std::string later = "cc" + kValid.substr(2);
  CHECK(parse_traceparent(later)->trace_id == kTraceId);
  CHECK(parse_traceparent(later + "-what-the-future-will-be-like")->sampled);
  CHECK(!parse_traceparent(later + ".what"));
  CHECK(!parse_traceparent(later + "0"));
}

TEST_CASE("trace: a client's trace continues under a new span") {
  const Trace trace = continue_trace(head_with({{"traceparent", kValid}, {"tracestate", "rojo=00f0,congo=t61"}}));
  CHECK(trace.trace_id == kTraceId);
  CHECK(trace.parent_id == kParentId);
  CHECK(is_hex(trace.span_id, 16));
  CHECK(trace.span_id != kParentId);
  CHECK(traceparent(trace) == "00-" + kTraceId + "-" + trace.span_id + "-01");
  const auto headers = trace_headers(trace);
  REQUIRE(headers.size() == 2);
  CHECK(headers[1] == std::pair<std::string, std::string>("tracestate", "rojo=00f0,congo=t61"));
  CHECK(continue_trace(head_with({{"traceparent", kValid}})).span_id != trace.span_id);
}

TEST_CASE("trace: a missing, invalid or repeated traceparent starts a new trace without state") {
  for (const Head& head :
       {head_with({{"tracestate", "a=b"}}), head_with({{"traceparent", kValid + "x"}, {"tracestate", "a=b"}}),
        head_with({{"traceparent", kValid}, {"traceparent", kValid}, {"tracestate", "a=b"}})}) {
    const Trace trace = continue_trace(head);
    CHECK(is_hex(trace.trace_id, 32));
    CHECK(trace.trace_id != kTraceId);
    CHECK(trace.parent_id.empty());
    CHECK(trace.state.empty());
    CHECK(!trace.sampled);
    CHECK(parse_traceparent(traceparent(trace)));
    CHECK(trace_headers(trace).size() == 1);
  }
}

TEST_CASE("trace: a state of several lines is one list") {
  const auto trace = continue_trace(head_with({{"traceparent", kValid}, {"tracestate", "a=1"}, {"tracestate", "b=2"}}));
  CHECK(trace.state == "a=1,b=2");
}

TEST_CASE("trace: a state that is too long or not printable is dropped, the trace is not") {
  const auto kept = [](const std::string& state) {
    const Trace trace = continue_trace(head_with({{"traceparent", kValid}, {"tracestate", state}}));
    CHECK(trace.trace_id == kTraceId);
    return trace.state == state && !state.empty();
  };
  CHECK(kept("a=b"));
  CHECK(kept("tenant@vendor=value with blanks"));
  CHECK(kept("a=1 , ,b=2"));
  CHECK(!kept("novalue"));
  CHECK(!kept(",,"));
  CHECK(!kept("a=\x01"));
  CHECK(!kept("a=\xc3\xa9"));
  CHECK(kept("a=" + std::string(510, 'v')));
  CHECK(!kept("a=" + std::string(511, 'v')));
}
