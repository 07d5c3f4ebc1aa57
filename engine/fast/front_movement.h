// The front of meshes with the same triangle indices: bounds/movement.h.
#pragma once

#include <vector>

#include "engine/fast/bounds/movement.h"
#include "engine/fast/front_work.h"

namespace meshgauge {

class MovementFront : private FrontWork {
 public:
  using FrontWork::FrontWork;
  using FrontWork::lower;

  FrontEnd run();

 private:
  FrontEnd settle();
  bool find_movers(const Movement& movement);
  bool raise_by_plane(const Vec3& movement);
  FrontEnd measure_movers(const Movement& movement);

  std::vector<std::uint32_t> movers_;  // triangles of A
};

}  // namespace meshgauge
