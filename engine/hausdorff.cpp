#include "engine/hausdorff.h"

namespace meshgauge {

const char* version() { return MESHGAUGE_VERSION; }

// Placeholder while the house is built: the trivial interval [0, diagonal of both].
Outcome measure(MeshView a, MeshView b, const Options& options, Control&) {
  Outcome outcome;
  Box box = bounding_box(a);
  box.extend(bounding_box(b));
  outcome.stop = Stop::timeout;
  outcome.upper = (box.high - box.low).norm() * 1.0000001;
  outcome.diagonal_a = diagonal(a);
  Directed directed;
  directed.bounds.upper = outcome.upper;
  directed.culling = {a.triangles.size(), a.triangles.size()};
  if (options.direction != Direction::b_to_a) outcome.a_to_b = directed;
  directed.culling = {b.triangles.size(), b.triangles.size()};
  if (options.direction != Direction::a_to_b) outcome.b_to_a = directed;
  return outcome;
}

}  // namespace meshgauge
