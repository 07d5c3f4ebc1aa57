#include "api/part_document.h"

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "api/gate.h"
#include "api/response.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;
using json = nlohmann::ordered_json;

namespace {

std::string obj_of(const Mesh& mesh) {
  std::string text;
  char line[100];
  for (const Vec3& p : mesh.positions) {
    text.append(
        line, static_cast<std::size_t>(std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z())));
  }
  for (const Triangle& t : mesh.triangles) {
    text.append(
        line, static_cast<std::size_t>(std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1)));
  }
  return text;
}

// Two files and what is asked of them.
struct Pair {
  std::string a = obj_of(shapes::sphere(16));
  std::string b = obj_of(shapes::sphere(13, 1.02, Vec3(0.01, 0, 0)));
  api::Request request;

  explicit Pair(unsigned shards = 3) { request.shards = shards; }

  api::Comparison measured(const Options& options, std::optional<std::uint64_t> cancel_at = std::nullopt) const {
    Control control;
    if (cancel_at) control.cancel_at_check(*cancel_at);
    const auto bytes = [](const std::string& text) { return std::as_bytes(std::span(text.data(), text.size())); };
    auto comparison = api::compare({"a", bytes(a), "a.obj", ""}, {"b", bytes(b), "b.stl", ""}, options, {}, control);
    REQUIRE(comparison.ok());
    return *comparison;
  }
  api::Comparison whole() const { return measured(request.options); }

  std::vector<std::string> documents() const {
    std::vector<std::string> all;
    for (unsigned i = 0; i < request.shards; ++i) {
      all.push_back(api::to_part_json(measured(api::options_of_part(request, i))));
    }
    return all;
  }
};

// What of a result does not depend on names and clocks.
json lasting(const api::Comparison& comparison) {
  json result = json::parse(api::to_json(comparison));
  result.erase("id");
  result.erase("timings_ms");
  return result;
}

std::string changed(const std::string& document, const std::function<void(json&)>& change) {
  json tree = json::parse(document);
  change(tree);
  return tree.dump();
}

void refuses(const std::string& document) {
  CAPTURE(document);
  const auto part = api::read_part(document);
  REQUIRE_FALSE(part.ok());
  CHECK(part.error().code == ErrorCode::internal);
}

}  // namespace

TEST_CASE("part: what is written is read, to the last bit") {
  const Pair pair;
  for (unsigned i = 0; i < 3; ++i) {
    const api::Comparison part = pair.measured(api::options_of_part(pair.request, i));
    const auto read = api::read_part(api::to_part_json(part));
    REQUIRE(read.ok());
    Outcome without_rule = part.outcome;
    without_rule.met_by.reset();  // of the part; the whole has its own
    CHECK(same_outcome(read->outcome, without_rule));
    CHECK(read->options.part.index == i);
    CHECK(read->options.part.count == 3);
    CHECK(read->a.sha256 == part.a.sha256);
    CHECK(read->b.notes.filename_says == api::Format::stl);
    CHECK(api::to_part_json(*read) == api::to_part_json(part));
  }
}

TEST_CASE("part: one part is the whole") {
  const Pair pair(1);
  const auto merged = api::merge_parts(pair.documents(), pair.request);
  REQUIRE(merged.ok());
  CHECK(lasting(*merged) == lasting(pair.whole()));
}

TEST_CASE("part: together they are a result like any other") {
  for (const unsigned shards : {2U, 3U, 64U}) {
    for (const Direction direction : {Direction::symmetric, Direction::a_to_b, Direction::b_to_a}) {
      Pair pair(shards);
      pair.request.options.direction = direction;
      pair.request.options.tolerance = {std::nullopt, 1e-5, std::nullopt};
      std::vector<std::string> documents = pair.documents();
      std::reverse(documents.begin(), documents.end());
      const auto merged = api::merge_parts(documents, pair.request);
      REQUIRE(merged.ok());
      const api::Comparison whole = pair.whole();
      CHECK(merged->outcome.lower <= whole.outcome.upper);
      CHECK(whole.outcome.lower <= merged->outcome.upper);
      CHECK(merged->outcome.stop == Stop::converged);
      CHECK(merged->outcome.met_by == Rule::diagonal);
      json result = lasting(*merged), expected = lasting(whole);
      CHECK(result["engine"]["shards"] == shards);
      CHECK(result["meshes"] == expected["meshes"]);
      CHECK(result["gate"] == expected["gate"]);
      CHECK(result["tolerance"]["asked"] == expected["tolerance"]["asked"]);
      for (const char* way : {"a_to_b", "b_to_a"}) {
        REQUIRE(result[way].is_null() == expected[way].is_null());
        if (!result[way].is_null()) CHECK(result[way]["culling"]["triangles"] == expected[way]["culling"]["triangles"]);
      }
      CHECK(merged->id.size() == 32);
    }
  }
}

TEST_CASE("part: the gate is decided by the whole") {
  Pair pair(3);
  const api::Comparison whole = pair.whole();
  pair.request.units = "mm";
  for (const double limit : {whole.outcome.lower * 0.9, whole.outcome.upper * 1.1}) {
    pair.request.options.max_distance = limit;
    pair.request.options.tolerance = {0.0, std::nullopt, std::nullopt};
    const auto merged = api::merge_parts(pair.documents(), pair.request);
    REQUIRE(merged.ok());
    const json result = json::parse(api::to_json(*merged));
    CHECK(result["status"] == "gate_decided");
    CHECK(result["verdict"] == (limit > whole.outcome.upper ? "pass" : "fail"));
    CHECK(result["gate"] == json{{"max_distance", limit}, {"units", "mm"}});
  }
}

TEST_CASE("part: one that ran out of time makes the whole time out, with an interval that holds") {
  Pair pair(3);
  pair.request.options.tolerance = {0.0, std::nullopt, std::nullopt};
  std::vector<std::string> documents = pair.documents();
  const api::Comparison cut = pair.measured(api::options_of_part(pair.request, 1), 8);
  REQUIRE(cut.outcome.stop == Stop::cancelled);
  documents[1] = changed(api::to_part_json(cut), [](json& part) { part["stop"] = "timeout"; });
  const auto merged = api::merge_parts(documents, pair.request);
  REQUIRE(merged.ok());
  CHECK(merged->outcome.stop == Stop::timeout);
  const api::Comparison whole = pair.whole();
  CHECK(merged->outcome.lower <= whole.outcome.upper);
  CHECK(merged->outcome.upper >= whole.outcome.lower);
  // The tolerance decides, not how the parts ended.
  pair.request.options.tolerance = {merged->outcome.upper, std::nullopt, std::nullopt};
  CHECK(api::merge_parts(documents, pair.request)->outcome.stop == Stop::converged);
}

TEST_CASE("part: a lower bound that went missing is noticed") {
  Pair pair(2);
  std::vector<std::string> documents;
  const double lower = pair.whole().outcome.lower;
  for (unsigned i = 0; i < 2; ++i) {
    Control control;
    control.know_lower(lower * 1.5);  // of a part that was lost
    const Mesh a = shapes::sphere(16), b = shapes::sphere(13, 1.02, Vec3(0.01, 0, 0));
    api::Comparison part = pair.measured(api::options_of_part(pair.request, i));
    part.outcome = measure(a, b, api::options_of_part(pair.request, i), control);
    CHECK(part.outcome.stop == Stop::converged);
    documents.push_back(api::to_part_json(part));
  }
  const auto merged = api::merge_parts(documents, pair.request);
  REQUIRE_FALSE(merged.ok());
  CHECK(merged.error().message.find("relied on") != std::string::npos);
}

TEST_CASE("part: work items are shared out") {
  Pair pair(3);
  CHECK(api::options_of_part(pair.request, 0).max_work_items == Options{}.max_work_items);
  pair.request.options.max_work_items = 8;
  std::uint64_t sum = 0;
  for (unsigned i = 0; i < 3; ++i) sum += api::options_of_part(pair.request, i).max_work_items;
  CHECK(sum == 8);
  pair.request.options.max_work_items = 1;
  CHECK(api::options_of_part(pair.request, 2).max_work_items == 1);
}

TEST_CASE("part: what is not exactly such a document is refused") {
  const std::string good = Pair().documents()[0];
  REQUIRE(api::read_part(good).ok());
  for (const char* text : {"", "{", "[]", "null", "{}", "{\"part\":{\"index\":0,\"count\":1}}", "\0"}) refuses(text);
  refuses(good + " ");
  refuses(good.substr(0, good.size() - 1));
  refuses("{\"part\":1," + good.substr(1));
  refuses(std::string(100'000, '['));
  const json tree = json::parse(good);
  for (const auto& [key, value] : tree.items()) {
    refuses(changed(good, [&](json& part) { part.erase(key); }));
    for (const json& other : {json(nullptr), json("x"), json(-1), json(0.5), json::array(), json::object()}) {
      const bool is_absent_direction = other.is_null() && (key == "a_to_b" || key == "b_to_a");
      if (other == value || is_absent_direction || (other == 0.5 && value.is_number_float())) continue;
      CAPTURE(key);
      refuses(changed(good, [&](json& part) { part[key] = other; }));
    }
  }
  refuses(changed(good, [](json& part) { part["more"] = 1; }));
  refuses(changed(good, [](json& part) { part["part"]["index"] = 3; }));
  refuses(changed(good, [](json& part) { part["part"]["count"] = 65; }));
  refuses(changed(good, [](json& part) { part["version"] = "0.0.1"; }));
  refuses(changed(good, [](json& part) { part["partition"] = 2; }));
  refuses(changed(good, [](json& part) { part["stop"] = "done"; }));
  refuses(changed(good, [](json& part) { part["simd"] = "mmx"; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["lower"] = 1e9; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["lower"] = -1.0; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["upper"] = nullptr; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["witness"] = nullptr; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["witness"]["triangle_a"] = 1'000'000; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["witness"]["triangle_b"] = 5'000'000'000; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["witness"]["point_a"] = {1.0, 2.0}; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["witness"]["point_a"][1] = nullptr; }));
  refuses(changed(good, [](json& part) { part["a_to_b"]["culling"]["survivors"] = 1'000'000; }));
  refuses(changed(good, [](json& part) { part["meshes"]["a"]["format"] = "dxf"; }));
  refuses(changed(good, [](json& part) { part["a_to_b"] = nullptr, part["b_to_a"] = nullptr; }));
}

TEST_CASE("part: those of different wholes do not go together") {
  const Pair pair;
  const std::vector<std::string> good = pair.documents();
  REQUIRE(api::merge_parts(good, pair.request).ok());
  const auto refused = [&](std::vector<std::string> documents, const api::Request& request) {
    const auto merged = api::merge_parts(documents, request);
    REQUIRE_FALSE(merged.ok());
    CHECK(merged.error().code == ErrorCode::internal);
  };
  refused({}, pair.request);
  refused({good[0], good[1]}, pair.request);
  refused({good[0], good[1], good[1]}, pair.request);
  refused({good[0], good[1], good[2], good[2]}, pair.request);
  refused({good[0], good[1], "{}"}, pair.request);
  refused(good, Pair(4).request);
  Pair other;
  other.request.options.direction = Direction::a_to_b;
  refused(good, other.request);
  refused({good[0], good[0], good[0]}, pair.request);
  other.request.options.direction = Direction::symmetric;
  other.a += "f 1 2 3\n";
  refused({good[0], good[1], other.documents()[2]}, pair.request);
  refused({good[0], good[1],
           changed(good[2],
                   [](json& part) {
                     part["a_to_b"]["culling"]["triangles"] = 1, part["a_to_b"]["culling"]["survivors"] = 0,
                     part["a_to_b"]["culling"]["rate"] = 1.0;
                   })},
          pair.request);
}
