#include "check/run/local.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "api/base/whole_file.h"
#include "api/compare/compare.h"
#include "api/result/response.h"
#include "check/run/gates.h"
#include "check/run/run.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;
using Json = nlohmann::ordered_json;

namespace {

Report run_here(const std::vector<Gate>& gates, const LocalOptions& options = {}) {
  const auto measurer = local(gates, std::make_shared<Meshes>(gates), options);
  return run(gates, *measurer);
}

// Without what differs from run to run.
Json steady(Json document) {
  for (const char* name : {"id", "timings_ms"}) document.erase(name);
  return document;
}

Json compared(const Gate& gate) {
  const auto a = api::WholeFile::open(gate.candidate.string()), b = api::WholeFile::open(gate.baseline.string());
  const api::ComparisonOptions options = gate.request.options;
  Control control;
  auto comparison = api::compare({"a", a->bytes(), gate.candidate.string(), ""},
                                 {"b", b->bytes(), gate.baseline.string(), ""}, options, {}, control);
  return Json::parse(api::to_json(*comparison));
}

}  // namespace

TEST_CASE("a gate's document is that of a comparison, with the same bits") {
  const Folder folder;
  Gate asked = gate(folder.obj("a.obj", shapes::sphere(12)), folder.obj("b.obj", shapes::sphere(11, 1.01)), 0.03);
  asked.request.options.units.limit = LengthUnit::millimeter;
  const Report report = run_here({asked, asked});
  for (const GateOutcome& outcome : report.outcomes) {
    REQUIRE(outcome.measured);
    CHECK(steady(outcome.measured->document) == steady(compared(asked)));
    CHECK(outcome.measured->document.at("gate").at("units") == "mm");
  }
}

TEST_CASE("verdicts of limits on both sides of the distance") {
  const Folder folder;
  const auto a = folder.obj("a.obj", shapes::grid(4, 1, 0)), b = folder.obj("b.obj", shapes::grid(5, 1, 2));
  const Report report = run_here({gate(a, b, 2.001), gate(a, b, 1.999)}, {4, 0});
  CHECK(report.outcomes[0].verdict() == Verdict::pass);
  CHECK(report.outcomes[1].verdict() == Verdict::fail);
  CHECK(report.exit_code() == 1);
}

TEST_CASE("a limit closer to the distance than one percent is decided") {
  const Folder folder;
  const auto a = folder.obj("a.obj", shapes::sphere(20)), b = folder.obj("b.obj", shapes::sphere(13, 1.02));
  Options options;
  options.tolerance = {0.0, std::nullopt, std::nullopt};
  const auto whole_a = api::WholeFile::open(a.string()), whole_b = api::WholeFile::open(b.string());
  Control control;
  const auto measured =
      api::compare({"a", whole_a->bytes(), "a.obj", ""}, {"b", whole_b->bytes(), "b.obj", ""}, options, {}, control);
  REQUIRE(measured);
  const double low = measured->outcome.lower, high = measured->outcome.upper;
  REQUIRE(high - low < 1e-6 * high);
  const Report report = run_here({gate(a, b, high * 1.0001), gate(a, b, low * 0.9999)});
  CHECK(report.outcomes[0].verdict() == Verdict::pass);
  CHECK(report.outcomes[1].verdict() == Verdict::fail);
}

TEST_CASE("a limit as a share is of the baseline's diagonal") {
  const Folder folder;
  // The baseline's diagonal is 10 * sqrt(2), the candidate's a tenth of that.
  Gate share = gate(folder.obj("a.obj", shapes::grid(4, 1)), folder.obj("b.obj", shapes::grid(4, 10)), 0);
  share.request.options.direction = Direction::a_to_b;
  set_share_of_diagonal(share, 0.01);
  const Report report = run_here({share});
  REQUIRE(report.outcomes[0].measured);
  CHECK(report.outcomes[0].measured->criteria.front().limit == doctest::Approx(0.01 * 10 * std::sqrt(2)));
  CHECK(report.outcomes[0].verdict() == Verdict::pass);
}

TEST_CASE("a file that is missing or damaged is an error that says which of the two") {
  const Folder folder;
  const auto good = folder.obj("good.obj", shapes::grid(2));
  const Report report = run_here({gate(folder.path() / "none.obj", good, 1), gate(good, folder.file("b.obj", "?"), 1)});
  REQUIRE(report.outcomes[0].error);
  CHECK(report.outcomes[0].error->part == "a");
  CHECK(report.outcomes[0].verdict() == Verdict::error);
  REQUIRE(report.outcomes[1].error);
  CHECK(report.outcomes[1].error->part == "b");
  CHECK(report.exit_code() == 3);
}

TEST_CASE("threads: those of the gate, else those of the processors that are free, one where more are of no use") {
  const Folder folder;
  const auto a = folder.obj("a.obj", shapes::sphere(8)), b = folder.obj("b.obj", shapes::sphere(9));
  const auto threads_of = [&](const Gate& asked, const LocalOptions& options) {
    const Report report = run_here({asked}, options);
    return report.outcomes[0].measured->document.at("engine").at("threads").get<unsigned>();
  };
  Gate asked = gate(a, b, 1e-3);
  CHECK(threads_of(asked, {3, 0}) == 3);
  asked.request.threads_given = true;
  asked.request.options.threads = 2;
  CHECK(threads_of(asked, {3, 0}) == 2);
  Gate confined = asked;  // for a client that is not trusted
  confined.request.options.threads = 64;
  confined.confines =
      std::make_shared<const api::Confines>(api::Confines{api::Roots::open({folder.path().string()}).value()});
  CHECK(threads_of(confined, {3, 0}) == 3);
  asked.request.options.strategy = Strategy::four_point;
  CHECK(threads_of(asked, {3, 0}) == 1);
}

TEST_CASE("the gate's timeout ends it with its interval") {
  const Folder folder;
  const auto a = folder.obj("a.obj", shapes::grid(40)), b = folder.obj("b.obj", shapes::grid(43));
  Gate hard = gate(a, b, 0);  // two flat grids: bisection approaches 0 for ever
  hard.request.options.strategy = Strategy::four_point;
  hard.request.options.tolerance = {0.0, std::nullopt, std::nullopt};
  hard.request.timeout = std::chrono::milliseconds(300);
  const Report report = run_here({hard});
  const GateOutcome& outcome = report.outcomes[0];
  CHECK(outcome.verdict() == Verdict::undecided);
  CHECK(!report.interrupted);
  if (outcome.measured) {  // else the machine was too busy to read within that time
    CHECK(outcome.measured->status == "timeout");
    CHECK(outcome.advice().find("longer timeout than 0.3 s") != std::string::npos);
  }
}

TEST_CASE("as many gates at once as processors, or as asked for, and no more than there are") {
  const std::vector<Gate> gates(5, gate("a", "b", 1));
  const auto at_once = [&](const LocalOptions& options) {
    return local(gates, std::make_shared<Meshes>(gates), options)->at_once();
  };
  CHECK(at_once({2, 0}) == 2);
  CHECK(at_once({2, 4}) == 4);
  CHECK(at_once({64, 0}) == 5);
}

TEST_CASE("a limit of the area alone, and beside one of the distance") {
  const Folder folder;
  // The candidate rises from 0 to 1 over the baseline: half of it is farther than a half.
  Mesh ramp = shapes::grid(6, 1);
  for (Vec3& p : ramp.positions) p.z() = p.x();
  const double flat = ramp.positions.front().z();
  const auto a = folder.obj("a.obj", ramp), b = folder.obj("b.obj", shapes::grid(5, 1, flat));
  const auto verdict_of = [&](double share, std::optional<double> max_distance) {
    Gate asked = gate(a, b, 0);
    set_area_limit(asked, {0.3, share});
    asked.request.options.max_distance = max_distance;
    const Report report = run_here({asked});
    REQUIRE(report.outcomes[0].measured);
    CHECK(report.outcomes[0].measured->criteria.back().beyond == 0.3);
    return report.outcomes[0].verdict();
  };
  CHECK(verdict_of(0.99, std::nullopt) == Verdict::pass);
  CHECK(verdict_of(0.01, std::nullopt) == Verdict::fail);
  CHECK(verdict_of(0.99, 10) == Verdict::pass);
  CHECK(verdict_of(0.01, 10) == Verdict::fail);
  CHECK(verdict_of(0.99, 0.1) == Verdict::fail);
}

TEST_CASE("a limit of the area that its time does not decide") {
  const Folder folder;
  Gate hard = gate(folder.obj("a.obj", shapes::grid(40)), folder.obj("b.obj", shapes::grid(43)), 0);
  set_area_limit(hard, {1e-5, 0.4});
  hard.request.options.strategy =
      Strategy::four_point;  // two flat grids: bisection approaches 0 for ever, before areas
  hard.request.options.tolerance = {0.0, std::nullopt, std::nullopt};
  hard.request.timeout = std::chrono::milliseconds(150);
  const Report report = run_here({hard});
  CHECK(report.outcomes[0].verdict() == Verdict::undecided);
  CHECK(report.exit_code() == 2);
  CHECK(report.outcomes[0].advice().find("longer timeout than 0.15 s") != std::string::npos);
}

TEST_CASE("a mesh without area has no share of it") {
  const Folder folder;
  const auto point = folder.obj("a.obj", shapes::triangle(Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)));
  Gate asked = gate(point, folder.obj("b.obj", shapes::grid(3)), 0);
  set_area_limit(asked, {0.1, 0.5});
  asked.request.options.direction = Direction::a_to_b;
  const Report report = run_here({asked});
  CHECK(report.outcomes[0].verdict() == Verdict::undecided);
  CHECK(report.outcomes[0].advice().find("no area") != std::string::npos);
}

TEST_CASE("few gates use all processors, many one each") {
  Processors few(8, 8, 3);
  CHECK(few.take(0) == 2);
  CHECK(few.take(0) == 3);
  CHECK(few.take(0) == 3);
  Processors many(4, 4, 100);
  for (int i = 0; i < 4; ++i) CHECK(many.take(0) == 1);
  many.give_back(1);
  CHECK(many.take(0) == 1);
  Processors one_by_one(8, 1, 5);
  CHECK(one_by_one.take(0) == 8);
  one_by_one.give_back(8);
  CHECK(one_by_one.take(0) == 8);
}

TEST_CASE("a gate with its own number of threads gets it, others get at least one") {
  Processors processors(4, 4, 4);
  CHECK(processors.take(6) == 6);
  CHECK(processors.take(0) == 1);
  processors.give_back(6);
  processors.give_back(1);
  CHECK(processors.take(0) == 2);
  CHECK(processors.take(0) == 2);
}

TEST_CASE("work beside the gates has the part of one of them") {
  CHECK(Processors::part(8, 1) == 8);
  CHECK(Processors::part(8, 3) == 2);
  CHECK(Processors::part(4, 100) == 1);
  CHECK(Processors::part(1, 0) == 1);
}

TEST_CASE("the last of many gates gets what has become free") {
  Processors processors(4, 4, 5);
  for (int i = 0; i < 4; ++i) CHECK(processors.take(0) == 1);
  processors.give_back(1);
  processors.give_back(1);
  processors.give_back(1);
  CHECK(processors.take(0) == 3);
}
