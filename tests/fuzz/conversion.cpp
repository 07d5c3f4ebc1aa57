#include "fuzz/conversion.h"

#include <cmath>
#include <cstdio>

#include "engine/mesh/scaling.h"
#include "engine/tree/prepared.h"
#include "oracle/farthest.h"

namespace meshgauge::fuzz {
namespace {

using oracle::Dyadic;
using oracle::Violation;

// The quotients of um, mm, cm, m, in and ft, in lowest terms; the first one is 1.
constexpr Factor kFactors[] = {{1, 1},      {1000, 1},   {1, 1000},   {10, 1},    {1, 10},    {100, 1},    {1, 100},
                               {127, 5},    {5, 127},    {127, 50},   {50, 127},  {12, 1},    {1, 12},     {381, 1250},
                               {1250, 381}, {127, 5000}, {5000, 127}, {25400, 1}, {1, 25400}, {304800, 1}, {1, 304800}};

// A mesh in another unit, and its exact surface there times `over` of both factors, which avoids quotients.
struct Converted {
  Converted(const Mesh& mesh, const Factor& factor, RoundedImage image, double other_over)
      : positions(std::move(image.positions)),
        prepared({positions, mesh.triangles}, Prepared::Use::once, nullptr, std::nullopt, image.error),
        surface(oracle::times(oracle::times(oracle::surface_of(mesh), factor.times), other_over)) {}

  std::vector<Vec3> positions;
  Prepared prepared;
  oracle::Surface surface;
};

Violation violation(const char* check, const Bounds& bounds, const Factor& a, const Factor& b) {
  char text[200];
  std::snprintf(text, sizeof text, "[%.17g, %.17g] of meshes times %g / %g and %g / %g", bounds.lower, bounds.upper,
                a.times, a.over, b.times, b.over);
  return {check, text};
}

}  // namespace

std::optional<Violation> attack_converted(const Pair& pair, const Options& options, const oracle::Effort& effort,
                                          Dice& dice) {
  const Factor factor_a = dice.pick(kFactors), factor_b = dice.pick(kFactors);
  auto image_a = scaled(pair.a, factor_a), image_b = scaled(pair.b, factor_b);
  if (!image_a || !image_b) return std::nullopt;
  const Converted a(pair.a, factor_a, *std::move(image_a), factor_b.over);
  const Converted b(pair.b, factor_b, *std::move(image_b), factor_a.over);
  const Dyadic over = Dyadic(factor_a.over) * Dyadic(factor_b.over);
  Control control;
  const Outcome outcome = measure(a.prepared, b.prepared, options, control);
  const auto check = [&](const std::optional<Directed>& directed, const Converted& from,
                         const Converted& to) -> std::optional<Violation> {
    if (!directed) return std::nullopt;
    const Bounds& bounds = directed->bounds;
    const auto sample = oracle::farthest_sample(from.surface, to.surface, effort.max_points);
    if (std::isfinite(bounds.upper) && !oracle::root_at_most(sample.distance_sq, over * Dyadic(bounds.upper))) {
      return violation("converted upper", bounds, factor_a, factor_b);
    }
    if (effort.max_splits == 0) return std::nullopt;
    const auto bracket = oracle::exact_bracket(from.surface, to.surface, effort.max_splits);
    if (oracle::root_at_least(bracket.upper_sq, over * Dyadic(bounds.lower))) return std::nullopt;
    return violation("converted lower", bounds, factor_a, factor_b);
  };
  const auto found = check(outcome.a_to_b, a, b);
  return found ? found : check(outcome.b_to_a, b, a);
}

}  // namespace meshgauge::fuzz
