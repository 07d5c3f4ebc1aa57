// Polygons and strips as triangles.
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

// Takes the corners of one triangle strip after another. Every second triangle is turned round, so that all face the
// same way. One with the same corner twice joins two strips that were made one; the segment that it spans leads through
// the air between them, and is no part of the surface.
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
  std::size_t joins() const { return joins_; }  // of all strips so far, left out

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
