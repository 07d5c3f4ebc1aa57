#include "check/html/gallery.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/run/gates.h"
#include "check/run/local.h"
#include "check/run/run.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

constexpr std::size_t kPassing = Gallery::kMostPictures + 20, kFailing = 5;

// Two files that are 1 apart, and gates of them: those that pass by their limits, from the nearest on, then those that
// fail.
struct Many {
  Folder folder;
  std::vector<Gate> gates;
  std::shared_ptr<Meshes> meshes;
  Report report;

  Many(std::size_t passing, std::size_t failing) {
    Mesh raised = shapes::grid(1);
    for (Vec3& p : raised.positions) p.z() += 1;
    const auto a = folder.obj("a.obj", shapes::grid(1)), b = folder.obj("b.obj", raised);
    for (std::size_t i = 0; i < passing; ++i) gates.push_back(gate(a, b, 2 + static_cast<double>(i)));
    for (std::size_t i = 0; i < failing; ++i) gates.push_back(gate(a, b, 0.5 + 0.01 * static_cast<double>(i)));
    for (std::size_t i = 0; i < gates.size(); ++i) gates[i].name = "gate " + std::to_string(i);
    meshes = std::make_shared<Meshes>(gates, 2);
    report = run(gates, *local(gates, meshes, {1, 1}));
    for (GateOutcome& outcome : report.outcomes) {
      REQUIRE(outcome.measured);
      for (Criterion& one : outcome.measured->criteria) one.lower = one.upper = 1;  // what is left open may differ
    }
  }
};

std::vector<std::size_t> in_any_order(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  return order;
}

}  // namespace

TEST_CASE("of very many gates those have pictures that fail or come nearest to their limits, in whatever order") {
  const Many many(kPassing, kFailing);
  Gallery gallery(many.meshes, many.gates.size(), true);
  Control control;
  for (const std::size_t i : in_any_order(many.gates.size())) gallery.draw(many.report.outcomes[i], false, 1, control);
  std::size_t told = 0;
  const auto pictures = gallery.end(many.report, 3, never_interrupted, [&](std::size_t done, std::size_t all) {
    CHECK(all == Gallery::kMostPassing);
    CHECK(done >= told);
    told = done;
  });
  REQUIRE(pictures.size() == many.gates.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    CAPTURE(i);
    const bool has_table = i >= kPassing || i < Gallery::kMostPictures - kFailing;
    const bool has_picture = i >= kPassing || i < Gallery::kMostPassing;
    CHECK(pictures[i].left_out == !has_table);
    CHECK(pictures[i].surfaces.empty() == !has_picture);
    CHECK(pictures[i].missing.empty() == (has_picture || !has_table));
  }
  CHECK(pictures[Gallery::kMostPassing].missing.find("nearest to their limits") != std::string::npos);
}

TEST_CASE("few gates have their pictures when they end, from the meshes in memory") {
  const Many many(2, 1);
  Gallery gallery(many.meshes, many.gates.size(), true);
  Control control;
  for (const GateOutcome& outcome : many.report.outcomes) gallery.draw(outcome, false, 1, control);
  std::filesystem::remove(many.folder.path() / "a.obj");
  for (const GatePicture& picture : gallery.end(many.report, 1, never_interrupted))
    CHECK_FALSE(picture.surfaces.empty());
}

TEST_CASE("a strip is made of every gate that it is asked for, with and without a report") {
  const Many many(2, 2);
  for (const bool for_report : {true, false}) {
    const auto meshes = std::make_shared<Meshes>(many.gates);
    Gallery gallery(meshes, many.gates.size(), for_report);
    Control control;
    for (std::size_t i = 0; i < many.gates.size(); ++i) {
      const auto made = gallery.draw(many.report.outcomes[i], i >= 2, 1, control);
      CHECK(made.png.empty() == (i < 2));
      CHECK(made.png.size() <= 200'000);
      CHECK(made.missing.empty());
    }
    const auto pictures = gallery.end(many.report, 1, never_interrupted);
    CHECK(pictures.size() == (for_report ? many.gates.size() : 0));
  }
}

TEST_CASE("a strip that cannot be made says why") {
  const Many many(0, 1);
  const auto meshes = std::make_shared<Meshes>(many.gates);
  std::filesystem::remove(many.folder.path() / "b.obj");
  Gallery gallery(meshes, 1, false);
  Control control;
  const auto made = gallery.draw(many.report.outcomes[0], true, 1, control);
  CHECK(made.png.empty());
  CHECK(made.missing.find("b.obj") != std::string::npos);
}

TEST_CASE("after an interruption nothing is drawn, and the report says so") {
  Many many(Gallery::kMostPassing + 1, 1);
  Gallery gallery(many.meshes, many.gates.size(), true);
  Control control;
  control.cancel();
  for (const GateOutcome& outcome : many.report.outcomes) {
    const auto made = gallery.draw(outcome, true, 1, control);
    CHECK(made.png.empty());
    CHECK(made.missing.empty());
  }
  many.report.interrupted = true;
  for (const GatePicture& picture : gallery.end(many.report, 1, never_interrupted)) {
    CHECK(picture.surfaces.empty());
    CHECK(picture.missing.find("interrupted") != std::string::npos);
  }
}
