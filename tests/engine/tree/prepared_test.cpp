#include "engine/tree/prepared.h"

#include <doctest/doctest.h>

#include <future>
#include <thread>

#include "engine/hausdorff.h"
#include "same_outcome.h"
#include "shapes.h"

using namespace meshgauge;

namespace {

Interrupted never() { return never_interrupted; }

Frame frame_of(const Mesh& a, const Mesh& b) {
  Box box = bounding_box(a);
  box.extend(bounding_box(b));
  return Frame(box);
}

const Kernels& kernels() { return *find_kernels("auto"); }

// A baseline and meshes that are compared with it: coarser, moved, changed in part, reordered, and far larger.
struct Partners {
  std::mt19937_64 random{91};
  Mesh baseline = shapes::sphere(40);
  std::vector<Mesh> others;

  Partners() {
    Mesh changed = baseline;
    for (std::size_t i = 0; i < changed.positions.size() / 8; ++i) changed.positions[i] *= 1.01;
    Mesh stirred = changed;
    std::shuffle(stirred.triangles.begin(), stirred.triangles.end(), random);
    others = {shapes::sphere(13),
              shapes::moved(baseline, {1e-3, 0, 0}),
              changed,
              stirred,
              shapes::scaled(shapes::sphere(9), 7),
              shapes::soup(60, random),
              shapes::cube(2, {3, 3, 3})};
  }
};

Options auto_options(Direction direction = Direction::symmetric) {
  Options options;
  options.direction = direction;
  options.tolerance = {std::nullopt, 1e-3, std::nullopt};
  return options;
}

Outcome fresh(const Mesh& a, const Mesh& b, const Options& options) {
  Control control;
  return measure(a, b, options, control);
}

Outcome prepared(const Prepared& a, const Prepared& b, const Options& options) {
  Control control;
  return measure(a, b, options, control);
}

}  // namespace

TEST_CASE("a prepared mesh gives the same bits regardless of its earlier use") {
  const Partners partners;
  for (const auto use : {Prepared::Use::once, Prepared::Use::often}) {
    const Prepared baseline(partners.baseline, use);
    for (int round = 0; round < 2; ++round) {
      for (const Mesh& mesh : partners.others) {
        const Prepared other(mesh, use);
        for (const auto direction : {Direction::a_to_b, Direction::b_to_a, Direction::symmetric}) {
          const Options options = auto_options(direction);
          CHECK(same_outcome(prepared(baseline, other, options), fresh(partners.baseline, mesh, options)));
          CHECK(same_outcome(prepared(other, baseline, options), fresh(mesh, partners.baseline, options)));
        }
        CHECK(same_outcome(prepared(other, other, auto_options()), fresh(mesh, mesh, auto_options())));
      }
    }
  }
}

TEST_CASE("every strategy and instruction set gets the same bits from one prepared mesh") {
  const Mesh a = shapes::sphere(12), b = shapes::scaled(shapes::sphere(9), 1.05);
  const Prepared from(a, Prepared::Use::often), to(b, Prepared::Use::often);
  for (int round = 0; round < 2; ++round) {
    for (const std::string_view simd : supported_simd()) {
      for (const auto strategy :
           {Strategy::automatic, Strategy::four_point, Strategy::n_point, Strategy::triangle_set}) {
        Options options = auto_options();
        options.simd = simd;
        options.strategy = strategy;
        options.points = 10;
        CHECK(same_outcome(prepared(from, to, options), fresh(a, b, options)));
      }
    }
  }
}

TEST_CASE("structures are kept for the next measurement, and their bytes are counted") {
  const Partners partners;
  const Prepared baseline(partners.baseline, Prepared::Use::often);
  const std::size_t bare = baseline.bytes();
  CHECK(bare >=
        partners.baseline.positions.size() * sizeof(Vec3) + partners.baseline.triangles.size() * sizeof(Triangle));
  const Mesh other = shapes::moved(shapes::sphere(39), {1e-3, 0, 0});
  const Frame frame = frame_of(partners.baseline, other);
  (void)prepared(baseline, Prepared(other), auto_options());
  const std::size_t after = baseline.bytes();
  CHECK(after > 2 * bare);

  Control told_to_stop;
  told_to_stop.cancel();
  ThreadPool pool(1);
  const auto framed = baseline.in(frame, kernels());
  CHECK(framed->order(told_to_stop, pool) != nullptr);
  CHECK(framed->tree(told_to_stop, pool) != nullptr);
  CHECK(baseline.positions([] { return true; }) != nullptr);
  (void)prepared(baseline, Prepared(other), auto_options());
  CHECK(baseline.bytes() == after);
}

TEST_CASE("the structures of the last frames are kept, those of earlier ones are released") {
  const Mesh mesh = shapes::sphere(20);
  const Prepared prepared(mesh);
  Control control;
  ThreadPool pool(1);
  std::vector<std::weak_ptr<Framed>> frames;
  std::size_t most = 0;
  for (int k = 0; k < 4; ++k) {
    const auto framed = prepared.in(frame_of(mesh, shapes::scaled(mesh, std::ldexp(1.0, k))), kernels());
    REQUIRE(framed->tree(control, pool));
    frames.push_back(framed);
    if (k == 1) most = prepared.bytes();
  }
  CHECK(frames[0].expired());
  CHECK(frames[1].expired());
  CHECK_FALSE(frames[2].expired());
  CHECK_FALSE(frames[3].expired());
  CHECK(prepared.bytes() == most);
  const auto again = prepared.in(frame_of(mesh, shapes::scaled(mesh, 4)), kernels());
  CHECK(again == frames[2].lock());
  (void)prepared.in(frame_of(mesh, mesh), kernels());
  CHECK(frames[3].expired());  // not frames[2], which was used more recently
}

TEST_CASE("an interruption at any check leaves no incomplete structure") {
  const Partners partners;
  for (const std::size_t i : {0U, 3U}) {
    const Mesh& mesh = partners.others[i];
    const Outcome whole = fresh(partners.baseline, mesh, auto_options());
    Control counter;
    (void)measure(partners.baseline, mesh, auto_options(), counter);
    for (std::uint64_t k = 1; k <= counter.checks(); k += 1 + k / 16) {
      const Prepared a(partners.baseline, Prepared::Use::often), b(mesh, Prepared::Use::often);
      Control control;
      control.cancel_at_check(k);
      const Outcome cut = measure(a, b, auto_options(), control);
      CHECK(cut.lower <= whole.upper);
      CHECK(whole.lower <= cut.upper);
      CHECK(same_outcome(prepared(a, b, auto_options()), whole));
    }
  }
}

TEST_CASE("simultaneous measurements share structures and give the same bits as alone") {
  const Partners partners;
  for (int round = 0; round < 3; ++round) {
    const Prepared baseline(partners.baseline, Prepared::Use::often);
    std::vector<std::future<bool>> same;
    for (std::size_t i = 0; i < 2 * partners.others.size(); ++i) {
      same.push_back(std::async(std::launch::async, [&, i] {
        const Mesh& mesh = partners.others[i % partners.others.size()];
        const Prepared other(mesh, Prepared::Use::often);
        if (i % 4 == 3) {  // some are interrupted, perhaps while others wait for their structures
          Control control;
          control.cancel_at_check(1 + i);
          (void)measure(baseline, other, auto_options(), control);
        }
        return same_outcome(prepared(baseline, other, auto_options()), fresh(partners.baseline, mesh, auto_options()));
      }));
    }
    for (auto& each : same) CHECK(each.get());
  }
}

TEST_CASE("measurements on several threads share a prepared mesh") {
  const Mesh a = shapes::sphere(80), b = shapes::sphere(70);
  const Prepared from(a, Prepared::Use::often), to(b, Prepared::Use::often);
  const Outcome one = fresh(a, b, auto_options());
  std::vector<std::future<Outcome>> outcomes;
  outcomes.reserve(3);
  for (int i = 0; i < 3; ++i) {
    outcomes.push_back(std::async(std::launch::async, [&, i] {
      Options options = auto_options();
      options.threads = 2;
      return i == 2 ? prepared(from, from, options) : prepared(from, to, options);
    }));
  }
  for (int i = 0; i < 3; ++i) {
    const Outcome outcome = outcomes[static_cast<std::size_t>(i)].get();
    CHECK(outcome.stop == Stop::converged);
    CHECK(outcome.lower <= (i == 2 ? 0 : one.upper));
    CHECK((i == 2 ? 0 : one.lower) <= outcome.upper);
  }
}

TEST_CASE(
    "a value is made once, and after an interruption by a waiting call, which returns null if interrupted itself") {
  Lazy<int> value;
  CHECK(value.peek() == nullptr);
  CHECK(value.get(never(), [] { return std::unique_ptr<const int>(); }) == nullptr);
  CHECK_THROWS_AS(value.get(never(), []() -> std::unique_ptr<const int> { throw std::bad_alloc(); }), std::bad_alloc);

  std::promise<void> begun, end;
  auto slow = std::async(std::launch::async, [&] {
    return value.get(never(), [&] {
      begun.set_value();
      end.get_future().wait();
      return std::unique_ptr<const int>();  // interrupted
    });
  });
  begun.get_future().wait();
  int asked = 0;
  CHECK(value.get([&] { return ++asked > 2; }, [] { return std::make_unique<const int>(1); }) == nullptr);
  auto waiting =
      std::async(std::launch::async, [&] { return value.get(never(), [] { return std::make_unique<const int>(2); }); });
  end.set_value();
  CHECK(slow.get() == nullptr);
  const int* made = waiting.get();
  REQUIRE(made);
  CHECK(*made == 2);
  CHECK(value.get(never(), [] { return std::make_unique<const int>(3); }) == made);
}
