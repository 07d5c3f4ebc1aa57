// The whole from its parts: every triangle is of one part, and the interval holds whatever the parts were told and
// whatever ended them.
#include "engine/part.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include "engine/prepared.h"
#include "fuzz/attack.h"
#include "fuzz/dice.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

constexpr std::uint64_t kPairs = MESHGAUGE_SANITIZED ? 40 : 400;

constexpr std::size_t kSizes[] = {0, 1, 2, 3, 7, 63, 64, 65, 2047, 2048, 4097, 100'000, 1'000'003};

bool meet(const Outcome& a, const Outcome& b) { return a.lower <= b.upper && b.lower <= a.upper; }

Outcome measured(const Pair& pair, Options options, const Part& part, double known = 0) {
  Control control;
  control.know_lower(known);
  options.part = part;
  return measure(pair.a, pair.b, options, control);
}

std::vector<Outcome> all_parts(const Pair& pair, const Options& options, unsigned count, double known = 0) {
  std::vector<Outcome> parts;
  for (unsigned i = 0; i < count; ++i) parts.push_back(measured(pair, options, {i, count}, known));
  return parts;
}

Options options_of(const Method& method, Dice& dice) {
  Options options;
  options.strategy = method.strategy;
  options.direction = static_cast<Direction>(dice.below(3));
  options.tolerance = {std::nullopt, dice.power(-6, -2), std::nullopt};
  options.max_work_items = 400;
  return options;
}

// Two surfaces that are near each other, of some ten thousand triangles: parts of many blocks.
Pair near_spheres() {
  Pair pair{shapes::sphere(64), shapes::sphere(50, 1.01, Vec3(0.003, 0, 0)), "spheres"};
  for (Vec3& p : pair.a.positions) p *= 1 + 0.02 * std::sin(9 * p.x()) * std::cos(7 * p.y());
  return pair;
}

}  // namespace

TEST_CASE("every triangle is of exactly one part") {
  for (const std::size_t triangles : kSizes) {
    std::vector<std::uint32_t> order(triangles);
    std::iota(order.begin(), order.end(), 0U);
    for (const unsigned count : {1U, 2U, 3U, 5U, 8U, 63U, 64U}) {
      std::vector<int> seen(triangles);
      std::size_t least = triangles, most = 0;
      for (unsigned i = 0; i < count; ++i) {
        const auto part = of_part(order, {i, count});
        REQUIRE(part.size() == size_of_part(triangles, {i, count}));
        CHECK(std::is_sorted(part.begin(), part.end()));
        for (const std::uint32_t t : part) ++seen[t];
        least = std::min(least, part.size());
        most = std::max(most, part.size());
      }
      CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
      CHECK(most - least <= std::max<std::size_t>(1, triangles / (32 * count)));
    }
  }
}

TEST_CASE("every part is of one direction, and both have some") {
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{1, 1}, {1, 1'000'000}, {1'000'000, 1}, {3000, 5000}}) {
    for (const unsigned count : {2U, 3U, 5U, 64U}) {
      std::vector<Part> of_a, of_b;
      for (unsigned i = 0; i < count; ++i) {
        const Share share = share_of({i, count}, Direction::symmetric, a, b);
        (share.direction == Direction::a_to_b ? of_a : of_b).push_back(share.part);
        CHECK(share_of({i, count}, Direction::b_to_a, a, b).direction == Direction::b_to_a);
        CHECK(share_of({i, count}, Direction::b_to_a, a, b).part.index == i);
      }
      REQUIRE(of_a.size() + of_b.size() == count);
      for (const auto& parts : {of_a, of_b}) {
        REQUIRE(!parts.empty());
        for (unsigned i = 0; i < parts.size(); ++i) {
          CHECK(parts[i].index == i);
          CHECK(parts[i].count == parts.size());
        }
      }
    }
  }
  CHECK(share_of({0, 1}, Direction::symmetric, 1, 1).direction == Direction::symmetric);
}

TEST_CASE("parts of any number, each alone, make an interval that an exact oracle finds no fault with") {
  for (std::uint64_t seed = 120'000; seed < 120'000 + kPairs; ++seed) {
    const Pair pair = generate(seed);
    Dice dice(seed);
    oracle::Judge judge(pair.a, pair.b, {});
    for (const Method& method : methods()) {
      const Options options = options_of(method, dice);
      const auto triangles = static_cast<unsigned>(std::max(pair.a.triangles.size(), pair.b.triangles.size()));
      const Outcome whole = measured(pair, options, {});
      for (const unsigned count : {1U, 2U, std::min(triangles, 63U) + 1}) {
        const Outcome outcome = joined(all_parts(pair, options, count), options);
        const auto violation = judge.judge(options, outcome, {false, false, true});
        if (violation) FAIL_CHECK("pair ", seed, ", ", method.name, ", ", count, " parts: ", violation->detail);
        CHECK(meet(outcome, whole));
        if (count == 1) CHECK(same_outcome(outcome, whole));
      }
    }
  }
}

// No interval relies on what a part is told, so that not even a lie makes one wrong.
TEST_CASE("parts that are told nonsense hold nevertheless") {
  for (std::uint64_t seed = 130'000; seed < 130'000 + kPairs; ++seed) {
    const Pair pair = generate(seed);
    Dice dice(seed);
    oracle::Judge judge(pair.a, pair.b, {});
    Options options = options_of(methods()[seed % methods().size()], dice);
    const Outcome whole = measured(pair, options, {});
    const double lies[] = {whole.upper * 1.5, whole.lower * (1 + 1e-15), 1e300, 5e-324,
                           whole.upper * dice.power(-3, 3)};
    const Outcome outcome = joined(all_parts(pair, options, 3, dice.pick(lies)), options);
    CHECK(meet(outcome, whole));
    for (const Outcome* seen : {&whole, &outcome}) {
      CHECK(oracle::root_at_most(judge.largest_seen_sq(options.direction), seen->upper));
    }
    CHECK(outcome.lower <= whole.upper);
  }
}

TEST_CASE("what no number says is not known") {
  Control control;
  for (const double senseless : {std::nan(""), -1.0, -0.0, HUGE_VAL, -HUGE_VAL}) control.know_lower(senseless);
  CHECK(control.known_lower() == 0);
  control.know_lower(2);
  control.know_lower(1);
  CHECK(control.known_lower() == 2);
}

TEST_CASE("a part gives the same bits each time, prepared or not, whatever the other parts do") {
  const Pair pair = near_spheres();
  const Prepared a(pair.a, Prepared::Use::often), b(pair.b, Prepared::Use::often);
  for (const Direction direction : {Direction::symmetric, Direction::a_to_b, Direction::b_to_a}) {
    Options options;
    options.direction = direction;
    for (unsigned i = 0; i < 3; ++i) {
      options.part = {i, 3};
      const Outcome first = measured(pair, options, options.part);
      CHECK(same_outcome(first, measured(pair, options, options.part)));
      Control control;
      CHECK(same_outcome(first, measure(a, b, options, control)));
    }
  }
}

TEST_CASE("parts at the same time, each told what the others report, end with the tolerance met") {
  const Pair pair = near_spheres();
  const Prepared a(pair.a, Prepared::Use::often), b(pair.b, Prepared::Use::often);
  for (const unsigned count : {2U, 4U}) {
    for (const double width : {1e-3, 1e-6}) {
      Options options;
      options.tolerance = {std::nullopt, width, std::nullopt};
      std::vector<Control> controls(count);
      std::vector<Outcome> outcomes(count);
      std::vector<std::thread> threads;
      for (unsigned i = 0; i < count; ++i) {
        threads.emplace_back([&, i] {
          const auto tell = [&](const Progress& progress) {
            for (Control& control : controls) control.know_lower(progress.lower);
          };
          controls[i].watch(tell, std::chrono::milliseconds(0));
          Options own = options;
          own.part = {i, count};
          outcomes[i] = measure(a, b, own, controls[i]);
        });
      }
      for (std::thread& thread : threads) thread.join();
      const Outcome outcome = joined(outcomes, options);
      CHECK(outcome.stop == Stop::converged);
      CHECK(outcome.met_by == Rule::diagonal);
      CHECK(outcome.a_to_b->culling.triangles == pair.a.triangles.size());
      CHECK(outcome.b_to_a->culling.triangles == pair.b.triangles.size());
      CHECK(meet(outcome, measured(pair, options, {})));
    }
  }
}

TEST_CASE("a lower bound that is known from the start spares work, and ends a gate") {
  const Pair pair = near_spheres();
  Options options;
  options.direction = Direction::a_to_b;
  options.tolerance = {std::nullopt, 1e-6, std::nullopt};
  const Outcome whole = measured(pair, options, {});
  std::uint64_t alone = 0, told = 0;
  for (unsigned i = 0; i < 8; ++i) {
    alone += measured(pair, options, {i, 8}).a_to_b->work.triangle_tests;
    const Outcome part = measured(pair, options, {i, 8}, whole.lower);
    told += part.a_to_b->work.triangle_tests;
    CHECK(part.stop == Stop::converged);
  }
  CHECK(told < alone);
  options.max_distance = whole.lower / 2;
  options.tolerance = {0, std::nullopt, std::nullopt};
  CHECK(measured(pair, options, {3, 8}, whole.lower).stop == Stop::gate_decided);
}
