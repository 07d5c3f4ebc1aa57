// Splits polygons and strips into triangles.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/mesh.h"

namespace meshgauge::api {

// Takes the corners of polygons one by one and appends their fan triangulation: (0 1 2), (0 2 3), ...
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

// Takes the corners of triangle strips one by one. Every second triangle is reversed, so that all face the same way. A
// triangle with a repeated corner joins two strips written as one; it is left out, since the segment that it spans is
// not part of the surface.
class Strip {
 public:
  explicit Strip(std::vector<Triangle>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }

  void add(std::uint32_t corner) {
    if (corners_ >= 2) add_triangle(corner);
    before_ = previous_;
    previous_ = corner;
    ++corners_;
  }

  std::size_t corners() const { return corners_; }
  std::size_t joins() const { return joins_; }  // triangles left out, in all strips so far

 private:
  void add_triangle(std::uint32_t corner) {
    if (before_ == previous_ || previous_ == corner || before_ == corner) {
      ++joins_;
    } else if (corners_ % 2 == 0) {
      triangles_.push_back({before_, previous_, corner});
    } else {
      triangles_.push_back({before_, corner, previous_});
    }
  }

  std::vector<Triangle>& triangles_;
  std::size_t corners_ = 0;
  std::size_t joins_ = 0;
  std::uint32_t before_ = 0;
  std::uint32_t previous_ = 0;
};

}  // namespace meshgauge::api
