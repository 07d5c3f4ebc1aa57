#include "check/html/gallery.h"

#include <algorithm>
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

TEST_CASE("of very many gates those have pictures that fail or come nearest to their limits, in whatever order") {
  const Folder folder;
  const auto a = folder.obj("a.obj", shapes::grid(1));
  Mesh raised = shapes::grid(1);
  for (Vec3& p : raised.positions) p.z() += 1;
  const auto b = folder.obj("b.obj", raised);  // the distance is 1
  const std::size_t passing = Gallery::kMostPictures + 20, failing = 5;
  std::vector<Gate> gates;
  for (std::size_t i = 0; i < passing; ++i) gates.push_back(gate(a, b, 2 + static_cast<double>(i)));
  for (std::size_t i = 0; i < failing; ++i) gates.push_back(gate(a, b, 0.5 + 0.01 * static_cast<double>(i)));
  for (std::size_t i = 0; i < gates.size(); ++i) gates[i].name = "gate " + std::to_string(i);
  const auto meshes = std::make_shared<Meshes>(gates, 2);
  Report report = run(gates, *local(gates, meshes, {1, 1}));
  for (GateOutcome& outcome : report.outcomes) {
    REQUIRE(outcome.measured);
    outcome.measured->lower = outcome.measured->upper = 1;  // what is left open may be more for the larger limit
  }
  std::vector<std::size_t> order(gates.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  Gallery gallery(meshes, 1);
  for (const std::size_t i : order) gallery.add(report.outcomes[i]);
  const auto pictures = gallery.end(report, never_interrupted);
  REQUIRE(pictures.size() == gates.size());
  for (std::size_t i = 0; i < passing + failing; ++i) {
    CAPTURE(i);
    const bool expected = i >= passing || i < Gallery::kMostPictures - failing;
    CHECK(pictures[i].left_out == !expected);
    CHECK(pictures[i].surfaces.empty() == !expected);
    CHECK(pictures[i].missing.empty());
  }
}
