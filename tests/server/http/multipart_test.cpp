#include "server/http/multipart.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::FieldHead;
using server::MultipartParser;

namespace {

struct Part {
  FieldHead head;
  std::string data;
  bool ended = false;
};

struct Collector final : server::MultipartSink {
  std::vector<Part> parts;

  Refusal begin(const FieldHead& field) override {
    parts.push_back({field, "", false});
    return std::nullopt;
  }
  Refusal data(std::string_view piece) override {
    parts.back().data.append(piece);
    return std::nullopt;
  }
  Refusal end() override {
    parts.back().ended = true;
    return std::nullopt;
  }
};

struct Parsed {
  std::vector<Part> parts;
  bool ok = false;
  std::string why;  // if not ok
};

Parsed parsed(const std::string& body, std::size_t step) {
  Collector collector;
  MultipartParser parser("XX", collector);
  std::optional<api::Problem> refusal;
  for (std::size_t i = 0; i < body.size() && !refusal; i += step) {
    refusal = parser.feed(std::string_view(body).substr(i, step));
  }
  if (!refusal) refusal = parser.finish();
  return {collector.parts, !refusal, refusal ? refusal->detail : ""};
}

// Returns why a body is refused; "": it is not. The same however the bytes arrive.
std::string why_refused(const std::string& body) {
  const std::string why = parsed(body, body.size()).why;
  for (std::size_t step = 1; step < 12; ++step) CHECK(parsed(body, step).why == why);
  return why;
}

std::string part(const std::string& head, const std::string& data) {
  return "--XX\r\n" + head + "\r\n\r\n" + data + "\r\n";
}
std::string named(const std::string& name) { return "Content-Disposition: form-data; name=\"" + name + "\""; }

}  // namespace

TEST_CASE("multipart: the same parts however the bytes arrive") {
  const std::string tricky = "line\r\n--X\r\n--\r\n\r\n-XX--\r\n";
  const std::string body = part(named("a") + "; filename=\"x.obj\"\r\nContent-Type: model/obj", tricky) +
                           part(named("b"), "") + part("content-disposition: FORM-DATA; name=options", "{}") +
                           "--XX--\r\n";
  for (std::size_t step = 1; step <= body.size(); ++step) {
    const Parsed result = parsed(body, step);
    REQUIRE(result.ok);
    REQUIRE(result.parts.size() == 3);
    CHECK(result.parts[0].head.name == "a");
    CHECK(result.parts[0].head.filename == "x.obj");
    CHECK(result.parts[0].head.content_type == "model/obj");
    CHECK(result.parts[0].data == tricky);
    CHECK(result.parts[1].data.empty());
    CHECK(result.parts[1].ended);
    CHECK(result.parts[2].head.name == "options");
    CHECK(result.parts[2].data == "{}");
  }
}

TEST_CASE("multipart: a preamble, an epilogue and blanks after a boundary are skipped") {
  const std::string parts = part(named("a"), "x") + part(named("b"), "y");
  const std::string padded = "--XX \t \r\n" + named("a") + "\r\n\r\nx\r\n--XX\t\r\n" + named("b") + "\r\n\r\ny\r\n";
  const std::string most(server::kMaxPreambleBytes - 2, 'p');
  for (const std::string& body :
       {"\r\n" + parts + "--XX--\r\n", "\r\n\r\n" + parts + "--XX--",
        "This is a message of parts.\r\n" + parts + "--XX--", "\n\r\r\n" + parts + "--XX--",
        "-\r\n--X\r\n" + parts + "--XX--", most + "\r\n" + parts + "--XX--", padded + "--XX-- \t\r\n",
        parts + "--XX--\r\nThe end.\r\n--X\r\n--", parts + "--XX--epilogue\r\n\r\n", parts + "--XX--\r\n--XX--\r\n"}) {
    for (const std::size_t step : {std::size_t{1}, std::size_t{3}, body.size()}) {
      const Parsed result = parsed(body, step);
      REQUIRE_MESSAGE(result.ok, result.why);
      REQUIRE(result.parts.size() == 2);
      CHECK(result.parts[0].data == "x");
      CHECK(result.parts[1].data == "y");
    }
  }
}

TEST_CASE("multipart: a part is never skipped as preamble or epilogue") {
  const std::string parts = part(named("a"), "x") + part(named("b"), "y");
  const std::string within = "a boundary begins a line, and lines end with CR LF";
  CHECK(why_refused("\xEF\xBB\xBF" + parts + "--XX--") ==
        "the first boundary '--XX' comes after byte 3 of the body, which does not end a line; " + within);
  CHECK(why_refused("\n" + parts + "--XX--").ends_with(within));
  CHECK(why_refused("text\n" + parts + "--XX--").ends_with(within));
  CHECK(why_refused("\r" + parts + "--XX--").ends_with(within));
  const std::string twice = "a boundary comes after the closing one, '--XX--', which ends the last part alone";
  CHECK(why_refused(part(named("a"), "x") + "--XX--\r\n" + part(named("b"), "y") + "--XX--") == twice);
  CHECK(why_refused(parts + "--XX--\r\n--XX") == twice);
  CHECK(why_refused(parts + "--XX--\r\n--XX-") == twice);
}

TEST_CASE("multipart: a body without a boundary, and a preamble that is too long") {
  const std::string no_line = "no line of the body is '--XX', the boundary that Content-Type names";
  for (const char* body : {"{}", "a=part.stl", "--YY\r\n", "\r\n--X", "-"}) CHECK(why_refused(body) == no_line);
  const std::string too_long = "no line of the body's first 8192 bytes is '--XX', the boundary that Content-Type names";
  const std::string longer(server::kMaxPreambleBytes - 1, 'p');
  CHECK(why_refused(longer + "\r\n" + part(named("a"), "x") + "--XX--") == too_long);
  CHECK(why_refused(std::string(20'000, '\n')) == too_long);
}

TEST_CASE("multipart: a body cut anywhere is incomplete") {
  const std::string body = part(named("a"), "data") + "--XX--";
  for (std::size_t length = 0; length < body.size(); ++length) CHECK(!parsed(body.substr(0, length), 7).ok);
  CHECK(parsed(body, 7).ok);
  CHECK(parsed(body + "\r\nepilogue", 7).ok);
}

TEST_CASE("multipart: what is malformed is refused") {
  const std::string end = "--XX--\r\n";
  CHECK(!parsed(part("Content-Type: x/y", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: attachment; name=\"a\"", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"\"", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a\"b", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a\x01\"", "") + end, 64).ok);
  CHECK(!parsed(part("nonsense", "") + end, 64).ok);
  CHECK(!parsed(part(named("a") + "; name=\"b\"", "") + end, 64).ok);
  CHECK(!parsed(part(named("a") + "; NAME=\"a\"", "") + end, 64).ok);
  CHECK(!parsed(part(named("a") + "; filename=\"x\"; filename=\"y\"", "") + end, 64).ok);
  CHECK(why_refused(part(named("a") + "\r\n" + named("b"), "") + end) ==
        "the header 'Content-Disposition' of a part was sent twice");
  CHECK(!parsed("--XXjunk\r\n" + named("a") + "\r\n\r\n\r\n" + end, 64).ok);
  CHECK(!parsed("--XX --\r\n", 64).ok);
  CHECK(why_refused("--XX\n" + named("a") + "\n\nx\n--XX--\n") ==
        "the line of the boundary '--XX' must end with CR LF, or with '--' after the last part");
  CHECK(!parsed("--XX\r\n" + std::string(10'000, 'h'), 64).ok);
}

TEST_CASE("multipart: quotes in a name are unescaped") {
  const Parsed result =
      parsed(part(R"(Content-Disposition: form-data; name="a"; filename="x\"y\\;z.obj")", "") + "--XX--", 9);
  REQUIRE(result.ok);
  CHECK(result.parts[0].head.filename == R"(x"y\;z.obj)");
}

TEST_CASE("multipart: a hostile head costs little time") {
  // A regular expression backtracks over this for minutes, or overflows the stack.
  std::string disposition = named("a");
  for (int i = 0; disposition.size() < 8000; ++i) disposition += "; x" + std::to_string(i) + "=\"\"";
  CHECK(parsed(part(disposition, "x") + "--XX--", 8192).ok);
}

TEST_CASE("multipart: the boundary of a Content-Type") {
  std::string boundary;
  CHECK(!server::find_boundary("multipart/form-data; boundary=abc", "multipart/form-data", boundary));
  CHECK(boundary == "abc");
  CHECK(!server::find_boundary("Multipart/Form-Data; charset=utf-8; Boundary=\"a b:c\"", "multipart/form-data",
                               boundary));
  CHECK(boundary == "a b:c");
  const auto problem = [](const std::string& type) {
    std::string unused;
    const auto refusal = server::find_boundary(type, "multipart/form-data", unused);
    REQUIRE(refusal.has_value());
    return *refusal;
  };
  for (const auto& [type, seen] : {std::pair("application/x-www-form-urlencoded; charset=utf-8",
                                             "Content-Type must be multipart/form-data, not "
                                             "'application/x-www-form-urlencoded'"),
                                   std::pair("", "Content-Type must be multipart/form-data; the request has none")}) {
    CHECK(problem(type).kind == api::ProblemKind::unsupported_media_type);
    CHECK(problem(type).detail == seen);
  }
  for (const char* type : {"multipart/form-data", "multipart/form-data; charset=utf-8", "multipart/form-data;"}) {
    CHECK(problem(type).kind == api::ProblemKind::malformed_request);
    CHECK(problem(type).detail.starts_with(
        "Content-Type multipart/form-data lacks its parameter 'boundary': do not set"));
  }
  for (const char* type :
       {"multipart/form-data; boundary=", "multipart/form-data; boundary=a b", "multipart/form-data; boundary=\"a",
        "multipart/form-data; boundary=a; boundary=b", "multipart/form-data; boundary=a; charset=x; Boundary=a"}) {
    CHECK(problem(type).kind == api::ProblemKind::malformed_request);
    CHECK(problem(type).detail.starts_with("the parameters of Content-Type are malformed; write boundary=TEXT"));
  }
  CHECK(problem("multipart/form-data; boundary=" + std::string(71, 'b')).detail ==
        "the boundary in Content-Type must have 1 to 70 characters, not 71");
  CHECK(problem("multipart/form-data; boundary=\"\"").detail ==
        "the boundary in Content-Type must have 1 to 70 characters, not 0");
}
