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
};

Parsed parsed(const std::string& body, std::size_t step) {
  Collector collector;
  MultipartParser parser("XX", collector);
  for (std::size_t i = 0; i < body.size(); i += step) {
    if (parser.feed(std::string_view(body).substr(i, step))) return {collector.parts, false};
  }
  return {collector.parts, !parser.finish()};
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

TEST_CASE("multipart: a body cut anywhere is incomplete") {
  const std::string body = part(named("a"), "data") + "--XX--";
  for (std::size_t length = 0; length < body.size(); ++length) CHECK(!parsed(body.substr(0, length), 7).ok);
  CHECK(parsed(body, 7).ok);
  CHECK(parsed(body + "\r\nepilogue", 7).ok);
}

TEST_CASE("multipart: what is malformed is refused") {
  const std::string end = "--XX--\r\n";
  CHECK(!parsed("preamble\r\n" + part(named("a"), "") + end, 64).ok);
  CHECK(!parsed(part("Content-Type: x/y", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: attachment; name=\"a\"", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"\"", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a\"b", "") + end, 64).ok);
  CHECK(!parsed(part("Content-Disposition: form-data; name=\"a\x01\"", "") + end, 64).ok);
  CHECK(!parsed(part("nonsense", "") + end, 64).ok);
  CHECK(!parsed("--XXjunk\r\n" + named("a") + "\r\n\r\n\r\n" + end, 64).ok);
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
  while (disposition.size() < 8000) disposition += "; filename=\"\"";
  CHECK(parsed(part(disposition, "x") + "--XX--", 8192).ok);
}

TEST_CASE("multipart: the boundary of a Content-Type") {
  std::string boundary;
  CHECK(!server::find_boundary("multipart/form-data; boundary=abc", "multipart/form-data", boundary));
  CHECK(boundary == "abc");
  CHECK(!server::find_boundary("Multipart/Form-Data; charset=utf-8; Boundary=\"a b:c\"", "multipart/form-data",
                               boundary));
  CHECK(boundary == "a b:c");
  const auto kind = [](const std::string& type) {
    std::string unused;
    const auto refusal = server::find_boundary(type, "multipart/form-data", unused);
    REQUIRE(refusal.has_value());
    return refusal->kind;
  };
  CHECK(kind("application/json") == api::ProblemKind::unsupported_media_type);
  CHECK(kind("") == api::ProblemKind::unsupported_media_type);
  CHECK(kind("multipart/form-data") == api::ProblemKind::malformed_request);
  CHECK(kind("multipart/form-data; boundary=") == api::ProblemKind::malformed_request);
  CHECK(kind("multipart/form-data; boundary=" + std::string(71, 'b')) == api::ProblemKind::malformed_request);
}
