// The unit frame: both meshes moved and scaled, exactly, so that every coordinate is at most 1 in magnitude.
//
// x -> (x - centre) * 2^-exponent, axis by axis. The scaling is by a power of two. The centre of an axis is 0 unless
// the meshes lie far from 0 there (all of one sign, and at least as far away as they are wide on their widest axis);
// then x and centre are within a factor of two of each other and the subtraction is exact (Sterbenz). So the map is an
// exact similarity, except for numbers that the scaling pushes below 2^-1022, which err by at most 2^-1075 in the
// frame: far below every slack. A part at offset 1e6 is therefore measured with the precision of its own size, not of
// its offset, and scaling all input by a power of two changes no bit of the computation.
//
// Exponent and centres are coarse: meshes whose joint boxes differ by little have the same frame, except for few near a
// limit between two steps, so that the structures of a mesh in its frame can be reused (engine/tree/prepared.h). The
// coarse centres cost at most two bits of precision.
#pragma once

#include <cmath>
#include <limits>

#include "engine/mesh.h"

namespace meshgauge {

class Frame {
 public:
  Frame() = default;
  // `box`: the joint box of both surfaces; finite, coordinates of at most kMaxCoordinate.
  explicit Frame(const Box& box);

  Vec3 to_frame(const Vec3& p) const { return (p - centre_) * factor_ * factor_rest_; }
  // Returns the nearest representable point.
  Vec3 from_frame(const Vec3& p) const;

  // The largest distance, in frame units, by which a point moves on its way from the frame to the meshes' coordinates
  // and back: half an ulp of an offset coordinate on each axis. Negligible unless the meshes lie far from 0.
  double rounding_of_points() const;

  // A length in the meshes' unit is the length in frame units times 2^exponent().
  int exponent() const { return exponent_; }
  // Rounds to nearest; may overflow to infinity or underflow to 0.
  double length_to_frame(double length) const;
  // Not below the exact length in frame units.
  double length_to_frame_up(double length) const {
    return std::nextafter(length_to_frame(length), std::numeric_limits<double>::infinity());
  }

  bool operator==(const Frame&) const = default;

 private:
  Vec3 centre_ = Vec3::Zero();
  int exponent_ = 0;
  // 2^-exponent as a product of two powers, as it may lie outside the range of double itself.
  double factor_ = 1;
  double factor_rest_ = 1;
};

}  // namespace meshgauge
