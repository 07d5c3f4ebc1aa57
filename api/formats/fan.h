// Polygons as triangles, and the limits on how many there may be.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/mesh.h"

namespace meshgauge::api {

// Takes the corners of one polygon after another and appends their fan triangulation: (0 1 2), (0 2 3), ...
class Fan {
 public:
  explicit Fan(std::vector<Triangle>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }

  void add(std::uint32_t corner) {
    if (corners_ == 0) first_ = corner;
    if (corners_ >= 2) triangles_.push_back({first_, previous_, corner});
    previous_ = corner;
    ++corners_;
  }

  std::size_t corners() const { return corners_; }

 private:
  std::vector<Triangle>& triangles_;
  std::size_t corners_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t previous_ = 0;
};

}  // namespace meshgauge::api
