#include "check/remote/answer.h"

#include <limits>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "api/compare/align.h"
#include "check/criteria.h"

using namespace meshgauge;
using namespace meshgauge::check;
using namespace meshgauge::check::service;

namespace {

const std::string kId(32, '0');
const std::string kBase = "http://service";

std::string line_of(const std::string& state, const std::string& result = "null", const std::string& problem = "null") {
  return R"({"position":2,"name":null,"comparison":")" + kId + R"(","state":")" + state +
         R"(","verdict":null,"result":)" + result + R"(,"problem":)" + problem + "}";
}

std::string batch_of(const std::string& running) {
  return R"({"id":")" + kId + R"(","state":"running","counts":{"total":4,"queued":1,"running":2},"running":)" +
         running + "}";
}

std::string problem(const std::string& slug, const std::string& detail, const std::string& part) {
  return R"({"type":"/problems/)" + slug + R"(","title":"t","status":422,"detail":")" + detail +
         R"(","errors":[{"part":")" + part + R"(","where":"line 3","message":"m"}]})";
}

Gate gate() {
  Gate gate;
  gate.candidate = "build/part.obj";
  gate.baseline = "baselines/part.obj";
  return gate;
}

net::HttpAnswer reply(int status, const std::string& body, const std::string& type = "application/problem+json") {
  net::HttpAnswer reply;
  reply.status = status;
  reply.body = body;
  reply.headers["content-type"] = type;
  return reply;
}

}  // namespace

TEST_CASE("answer: the intervals of a batch's comparisons that run") {
  const auto state = batch_from(batch_of(R"([{"position":1,"progress":{"lower":0.25,"upper":null,"stage":"reduce"}},)"
                                         R"({"position":3,"progress":null},{"position":4,"progress":null},7,{}])"));
  REQUIRE(state);
  CHECK(state->ended == 1);
  REQUIRE(state->running.size() == 2);
  CHECK(state->running[0].first == 1);
  CHECK(state->running[0].second.lower == 0.25);
  CHECK(state->running[0].second.upper == std::numeric_limits<double>::infinity());
  CHECK(state->running[0].second.stage == std::string("reduce"));
  CHECK(state->running[1].first == 3);
  CHECK(state->running[1].second.stage == std::string("read"));
  for (const char* none : {"null", "7", "[]", R"({"position":1})"}) CHECK(batch_from(batch_of(none))->running.empty());
}

TEST_CASE("answer: how a comparison ended") {
  const std::string result = R"({"id":")" + kId + R"(","status":"cancelled"})";
  const auto ended = batch_line_from(line_of("cancelled", result));
  REQUIRE(ended);
  CHECK(ended->position == 2);
  REQUIRE(ended->end->document);
  CHECK(ended->end->document->at("status") == "cancelled");
  const auto failed = batch_line_from(line_of("failed", "null", problem("unreadable-mesh", "no", "a")));
  REQUIRE(failed);
  REQUIRE(failed->end->problem);
  CHECK(failed->end->problem->slug == "unreadable-mesh");
}

TEST_CASE("answer: malformed answers are rejected") {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const std::vector<std::string> bodies{"",
                                        "null",
                                        "[]",
                                        "{}",
                                        "<html>",
                                        line_of("finished"),
                                        line_of("running"),
                                        R"({"position":0,"comparison":"../../etc","state":"done"})",
                                        R"({"position":0,"comparison":7,"state":7})",
                                        R"({"id":"../etc","state":"done","counts":{"total":1,"queued":0,"running":0}})",
                                        deep,
                                        R"({"a":)" + deep + "}",
                                        line_of("done") + "x",
                                        batch_of("[]") + "x",
                                        "{\"id\":\"\xff\"}"};
  for (const std::string& body : bodies) {
    CAPTURE(body.substr(0, 80));
    CHECK_FALSE(batch_line_from(body));
    CHECK_FALSE(batch_from(body));
  }
  for (const std::string& none :
       {R"({"id":")" + kId + R"(","status":"\u001b[31m"})", std::string(R"({"status":"no such"})")})
    CHECK_FALSE(batch_line_from(line_of("done", none))->end->document);
}

TEST_CASE("answer: numbers are those that were sent") {
  const auto document = document_from(R"({"upper":0.097657647798235301,"lower":5e-324})");
  REQUIRE(document);
  CHECK(document->at("upper").get<double>() == 0.097657647798235301);
  CHECK(document->at("lower").get<double>() == 5e-324);
}

TEST_CASE("answer: the digest of each mesh") {
  const auto document = document_from(R"({"meshes":{"a":{"sha256":"12"},"b":7}})");
  REQUIRE(document);
  CHECK(sha256_of(*document, "a") == "12");
  CHECK(sha256_of(*document, "b").empty());
  CHECK(sha256_of(*document, "c").empty());
  CHECK(sha256_of(*document_from("{}"), "a").empty());
}

TEST_CASE("answer: a comparison is checked against the gate") {
  const auto is_answer = [](const std::string& body) {
    Gate asked;
    asked.request.options.direction = Direction::a_to_b;
    set_limit(asked, 0.1, asked.request.options.units.limit);
    return is_answer_to(*document_from(body), asked);
  };
  CHECK_FALSE(is_answer(R"({"direction":"a_to_b","gate":{"max_distance":0.1,"units":null}})"));
  CHECK(is_answer(
      R"({"unit":{"name":null,"source":"unknown"},"direction":"a_to_b","gate":{"max_distance":0.1,"units":null}})"));
  for (const char* body :
       {R"({"direction":"b_to_a","gate":{"max_distance":0.1}})", R"({"direction":7,"gate":{"max_distance":0.1}})",
        R"({"gate":{"max_distance":0.1}})", R"({"direction":"a_to_b","gate":{"max_distance":0.10000000000000002}})",
        R"({"direction":"a_to_b","gate":{"max_distance":"0.1"}})", R"({"direction":"a_to_b","gate":{}})",
        R"({"direction":"a_to_b","gate":null})", R"({"direction":"a_to_b"})"}) {
    CAPTURE(body);
    CHECK_FALSE(is_answer(body));
  }
}

TEST_CASE("answer: the limit of the area is compared, too") {
  const auto is_answer = [](const std::string& gate) {
    const std::string unit = R"({"unit":{"name":null,"source":"unknown"},"direction":"symmetric","gate":)";
    Gate asked;
    set_area_limit(asked, {0.1, 0.01});
    return is_answer_to(*document_from(unit + gate + "}"), asked);
  };
  CHECK(is_answer(R"({"max_distance":null,"max_share_beyond":{"distance":0.1,"share":0.01},"units":null})"));
  CHECK_FALSE(is_answer(R"({"max_distance":0.1,"max_share_beyond":{"distance":0.1,"share":0.01},"units":null})"));
  CHECK_FALSE(is_answer(R"({"max_distance":null,"max_share_beyond":{"distance":0.1,"share":0.02},"units":null})"));
  CHECK_FALSE(is_answer(R"({"max_distance":null,"units":null})"));
}

TEST_CASE("answer: what is expected is compared, too") {
  Gate asked;
  set_limit(asked, 0.1);
  const auto is_answer = [&](const std::string& expect) {
    return is_answer_to(
        *document_from(R"({"unit":{"name":null},"direction":"symmetric","gate":{"max_distance":0.1})" + expect + "}"),
        asked);
  };
  CHECK(is_answer(""));
  CHECK_FALSE(is_answer(R"(,"expect":{"triangles":12})"));
  asked.request.options.expect.triangles = api::Span{12, 12};
  CHECK(is_answer(R"(,"expect":{"triangles":12})"));
  for (const char* other : {"", R"(,"expect":{"triangles":13})", R"(,"expect":{"triangles":12,"watertight":true})",
                            R"(,"expect":null)", R"(,"expect":12)"})
    CHECK_FALSE(is_answer(other));
}

TEST_CASE("answer: the candidate was moved as asked for") {
  Gate asked;
  const auto motion = [](double x) {
    RigidMotion made;
    made.translation.x() = x;
    return made;
  };
  nlohmann::ordered_json body{{"direction", "symmetric"},
                              {"unit", {{"name", nullptr}, {"source", "unknown"}}},
                              {"gate", {{"max_distance", 0.1}, {"units", nullptr}}}};
  const auto is_answer = [&] { return is_answer_to(body, asked); };
  set_limit(asked, 0.1);
  CHECK(is_answer());
  asked.request.options.align.emplace();
  CHECK_FALSE(is_answer());
  for (const bool fit : {false, true}) {
    asked.request.options.align = AlignOptions{motion(2), fit, false, fit ? 0.5 : 1};
    const api::Aligned moved{{motion(fit ? 3 : 2)}, {}};
    body["alignment"] = api::json_of(moved, *asked.request.options.align);
    CHECK(is_answer());
    for (AlignOptions other :
         {AlignOptions{motion(2), fit, true, fit ? 0.5 : 1}, AlignOptions{motion(2), fit, false, 0.9},
          AlignOptions{motion(1), fit, false, fit ? 0.5 : 1}, AlignOptions{motion(2), !fit, false, fit ? 0.5 : 1}}) {
      body["alignment"] = api::json_of(fit ? moved : api::Aligned{{other.start}, {}}, other);
      CHECK_FALSE(is_answer());
    }
    const AlignOptions nowhere{{}, fit, false, fit ? 0.5 : 1};
    body["alignment"] = api::json_of(fit ? moved : api::Aligned{{nowhere.start}, {}}, nowhere);
    CHECK(is_answer() == fit);  // an older service does not say from where it fitted
    for (const char* wrong : {"null", "7", "[]", "{}"}) {
      body["alignment"] = nlohmann::ordered_json::parse(wrong);
      CHECK_FALSE(is_answer());
    }
  }
}

TEST_CASE("answer: a result without units is not accepted") {
  Gate asked;
  set_limit(asked, 0.1, LengthUnit::millimeter);
  asked.request.options.units.a = LengthUnit::inch;
  const auto is_answer = [&](const std::string& more) {
    const std::string body = R"({"direction":"symmetric","gate":{"max_distance":0.1,"units":"mm"})" + more + "}";
    set_limit(asked, 0.1, asked.request.options.units.limit);
    return is_answer_to(*document_from(body), asked);
  };
  const std::string mesh_a = R"(,"meshes":{"a":{"unit":{"name":"in","source":"declared"}}})";
  CHECK(is_answer(R"(,"unit":{"name":"mm","source":"declared"})" + mesh_a));
  for (const std::string& more :
       {std::string(), mesh_a, R"(,"unit":{"name":"m","source":"file"})" + mesh_a,
        std::string(R"(,"unit":{"name":"mm","source":"declared"})"), R"(,"unit":"mm")" + mesh_a}) {
    CAPTURE(more);
    CHECK_FALSE(is_answer(more));
  }
}

TEST_CASE("answer: a mesh that is refused is named by its file") {
  const auto refused = problem_from(std::string_view(problem("unreadable-mesh", "line 3 of 'b': no", "b")));
  REQUIRE(refused);
  const Error error = error_of(*refused, gate(), kBase);
  CHECK(error.code == ErrorCode::unreadable_mesh);
  CHECK(error.message == "line 3 of 'baselines/part.obj': no");
  CHECK(error.part == "b");
  CHECK(error.where == "line 3");
}

TEST_CASE("answer: every kind of problem that a mesh can have keeps its code") {
  const std::pair<const char*, ErrorCode> cases[] = {{"unsupported-format", ErrorCode::unsupported_format},
                                                     {"unreadable-mesh", ErrorCode::unreadable_mesh},
                                                     {"empty-mesh", ErrorCode::empty_mesh},
                                                     {"non-finite-vertex", ErrorCode::non_finite_vertex},
                                                     {"index-out-of-range", ErrorCode::index_out_of_range},
                                                     {"coordinate-too-large", ErrorCode::coordinate_too_large},
                                                     {"too-large", ErrorCode::too_large},
                                                     {"out-of-time", ErrorCode::out_of_time},
                                                     {"unit-conflict", ErrorCode::unit_conflict},
                                                     {"invalid-request", ErrorCode::invalid_request}};
  for (const auto& [slug, code] : cases) {
    CAPTURE(slug);
    CHECK(error_of(*problem_from(std::string_view(problem(slug, "d", "a"))), gate(), kBase).code == code);
  }
}

TEST_CASE("answer: a service of version 0.1 names its problems otherwise") {
  const auto problem = problem_from(std::string_view(R"({"type":"urn:meshgauge:problem:empty-mesh","detail":"d"})"));
  REQUIRE(problem);
  CHECK(problem->slug == "empty-mesh");
}

TEST_CASE("answer: a refusal says what to do") {
  const std::string body = R"({"type":"/problems/unauthorized","detail":"send a key","errors":[]})";
  CHECK(error_of(reply(401, body), gate(), kBase, false).message ==
        "the service at http://service says: send a key (give a key by --key-file or MESHGAUGE_KEY)");
  CHECK(error_of(reply(401, body), gate(), kBase, true).message.ends_with("(the key is not accepted)"));
}

TEST_CASE("answer: replies of other programs are named") {
  net::HttpAnswer moved = reply(301, "", "text/html");
  moved.redirect = "https://elsewhere/\n::error::";
  CHECK(error_of(moved, gate(), kBase, false).message ==
        "http://service does not answer as a meshgauge service: it redirects to https://elsewhere/ ::error::; give the "
        "address of the service itself");
  CHECK(error_of(reply(404, "<html>", "text/html"), gate(), kBase, false).message ==
        "http://service does not answer as a meshgauge service: it answers 404 with a body of text/html");
}

TEST_CASE("answer: a message is one line of limited length") {
  const std::string detail = "a\\n\\u001b[31m" + std::string(100'000, 'x');
  const Error error = error_of(*problem_from(std::string_view(problem("forbidden", detail, ""))), gate(), kBase);
  CHECK(error.message.size() < 1000);
  CHECK(error.message.find('\n') == std::string::npos);
  CHECK(error.message.find('\x1b') == std::string::npos);
}

TEST_CASE("answer: the page of a comparison has one form") {
  const std::string id = "0d67c9a2d1b307386f8fc157855c4351";
  nlohmann::ordered_json comparison{{"id", id}, {"view", "/c/" + id}, {"status", "converged"}};
  CHECK(take_view(comparison) == "/c/" + id);
  CHECK_FALSE(comparison.contains("view"));
  CHECK(take_view(comparison).empty());
  for (const nlohmann::ordered_json& view : std::initializer_list<nlohmann::ordered_json>{
           "https://evil.example/c/" + id, "//evil.example/c/" + id, "/c/" + id + "/..", "/c/", "", nullptr, 7}) {
    comparison["view"] = view;
    CAPTURE(view.dump());
    CHECK(take_view(comparison).empty());
    CHECK_FALSE(comparison.contains("view"));
  }
}

TEST_CASE("answer: the page of a batch has one form") {
  const std::string id = "0d67c9a2d1b307386f8fc157855c4351";
  nlohmann::ordered_json batch{
      {"id", id}, {"state", "running"}, {"counts", {{"total", 2}, {"queued", 1}, {"running", 0}}}};
  CHECK(batch_from(batch.dump())->view.empty());
  batch["view"] = "/b/" + id;
  CHECK(batch_from(batch.dump())->view == "/b/" + id);
  for (const nlohmann::ordered_json& view : std::initializer_list<nlohmann::ordered_json>{
           "https://evil.example/b/" + id, "//evil.example/b/" + id, "/b/" + id + "/..", "/c/" + id, "", nullptr, 7}) {
    batch["view"] = view;
    CAPTURE(view.dump());
    CHECK(batch_from(batch.dump())->view.empty());
  }
}
