#include "api/options/batch_request.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;

namespace {

const std::string kA(64, 'a');
const std::string kB(64, 'b');

std::string pair(const std::string& more = "") { return R"({"a":")" + kA + R"(","b":")" + kB + "\"" + more + "}"; }
std::string batch(const std::string& pairs, const std::string& more = "") {
  return R"({"comparisons":[)" + pairs + "]" + more + "}";
}

api::BatchLimits limits(bool parts = false) {
  api::BatchLimits limits;
  limits.max_pairs = 3;
  limits.parts = parts;
  return limits;
}

api::BatchRequest parsed(const std::string& json, bool parts = false) {
  auto request = api::parse_batch(json, "body", limits(parts));
  REQUIRE_MESSAGE(request.ok(), json);
  return std::move(*request);
}

Error refused_batch(const std::string& json, bool parts = false) {
  const auto request = api::parse_batch(json, "body", limits(parts));
  REQUIRE_MESSAGE(!request.ok(), json);
  CHECK(request.error().part == "body");
  return request.error();
}

}  // namespace

TEST_CASE("batch request: names, meshes and parts arrive") {
  const auto request =
      parsed(R"({"name":"all","comparisons":[{"name":"one","a":")" + kA + R"(","b":{"part":"new"}}]})", true);
  CHECK(request.name == "all");
  REQUIRE(request.pairs.size() == 1);
  CHECK(request.pairs[0].name == "one");
  CHECK(request.pairs[0].a.id == kA);
  CHECK(request.pairs[0].a.part.empty());
  CHECK(request.pairs[0].b.id.empty());
  CHECK(request.pairs[0].b.part == "new");
}

TEST_CASE("batch request: a comparison's options override those of the batch, member by member") {
  const auto request = parsed(batch(
      pair() + "," + pair(R"(,"options":{"gate":{"max_distance":2}})") + "," + pair(R"(,"options":{"timeout_ms":7})"),
      R"(,"options":{"threads":2,"gate":{"max_distance":1,"units":"mm"}})"));
  REQUIRE(request.options.size() == 3);
  CHECK(request.options[request.pairs[0].options] == R"({"gate":{"max_distance":1,"units":"mm"},"threads":2})");
  CHECK(request.options[request.pairs[1].options] == R"({"gate":{"max_distance":2},"threads":2})");
  CHECK(request.options[request.pairs[2].options] ==
        R"({"gate":{"max_distance":1,"units":"mm"},"threads":2,"timeout_ms":7})");
}

TEST_CASE("batch request: equal options are one entry, in any spelling") {
  const auto request = parsed(batch(pair() + "," + pair(R"(,"options":{ "threads" : 2, "direction":"a_to_b"})") + "," +
                                        pair(R"(,"options":{"direction":"a_to_b"})"),
                                    R"(,"options":{"threads":2})"));
  CHECK(request.options.size() == 2);
  CHECK(request.pairs[1].options == request.pairs[2].options);
  CHECK(request.pairs[0].options != request.pairs[1].options);
  CHECK(parsed(batch(pair())).options == std::vector<std::string>{"{}"});
}

TEST_CASE("batch request: errors name the place") {
  CHECK(refused_batch("[]").where.empty());
  CHECK(refused_batch("{").where.starts_with("byte "));
  CHECK(refused_batch(R"({"comparisons":[],"comparisons":[]})").where == "/comparisons");
  CHECK(refused_batch("{}").where == "/comparisons");
  CHECK(refused_batch(batch("")).where == "/comparisons");
  CHECK(refused_batch(batch(pair(), R"(,"gates":1)")).where == "/gates");
  CHECK(refused_batch(batch(pair(), R"(,"name":"")")).where == "/name");
  CHECK(refused_batch(batch(pair(), R"(,"name":"a\tb")")).where == "/name");
  CHECK(refused_batch(batch(pair(), R"(,"name":")" + std::string(256, 'x') + "\"")).where == "/name");
  CHECK(refused_batch(batch(pair() + "," + pair(R"(,"c":1)"))).where == "/comparisons/1/c");
  CHECK(refused_batch(batch(R"({"a":")" + kA + "\"}")).where == "/comparisons/0/b");
  CHECK(refused_batch(batch(R"({"b":")" + kA + R"(","a":{"part":"x"}})")).where == "/comparisons/0/a");
  CHECK(refused_batch(batch(R"({"b":")" + kA + R"(","a":{}})"), true).where == "/comparisons/0/a/part");
  CHECK(refused_batch(batch(R"({"b":")" + kA + R"(","a":{"part":""}})"), true).where == "/comparisons/0/a/part");
  CHECK(refused_batch(batch(pair(), R"(,"options":{"gate":{"max_distance":-1}})")).where ==
        "/options/gate/max_distance");
  CHECK(refused_batch(batch(pair(R"(,"options":{"threads":0})"), R"(,"options":{"strategy":"n_point"})")).where ==
        "/comparisons/0/options/threads");
  CHECK(refused_batch(batch(pair(R"(,"options":{"threads":1})"), R"(,"options":{"tolerence":1})")).where ==
        "/options/tolerence");
}

TEST_CASE("batch request: the numbers of comparisons and bytes are limited") {
  CHECK(parsed(batch(pair() + "," + pair() + "," + pair())).pairs.size() == 3);
  CHECK(refused_batch(batch(pair() + "," + pair() + "," + pair() + "," + pair())).code == ErrorCode::too_large);
  api::BatchLimits small = limits();
  small.max_bytes = batch(pair()).size() - 1;
  CHECK(api::parse_batch(batch(pair()), "body", small).error().code == ErrorCode::too_large);
}
