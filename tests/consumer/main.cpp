// The example of docs/library.md (the engine as a library) with a check: exits with 0 if the interval is right.
#include <chrono>
#include <cstdio>

#include "engine/hausdorff.h"

namespace {

int measure_two_triangles() {
  const meshgauge::Mesh a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const meshgauge::Mesh b{{{0, 0, 0.5}, {1, 0, 0.5}, {0, 1, 0.5}}, {{0, 1, 2}}};
  for (const auto* mesh : {&a, &b}) {
    const auto valid = meshgauge::validate(*mesh, meshgauge::MeshLimits{}, mesh == &a ? "a" : "b");
    if (!valid) return std::fprintf(stderr, "%s\n", valid.error().message.c_str()), 3;
  }

  meshgauge::Options options;
  options.tolerance = {.absolute = 1e-9, .diagonal = {}, .relative = {}};
  meshgauge::Control control(meshgauge::Control::Clock::now() + std::chrono::seconds(10));
  const meshgauge::Outcome outcome = meshgauge::measure(a, b, options, control);
  std::printf("meshgauge %s: the distance is in [%.17g, %.17g]\n", meshgauge::version(), outcome.lower, outcome.upper);

  const bool right = outcome.lower <= 0.5 && 0.5 <= outcome.upper && outcome.upper - outcome.lower <= 1e-9;
  return right && outcome.stop == meshgauge::Stop::converged ? 0 : 1;
}

}  // namespace

int main() { return measure_two_triangles(); }
