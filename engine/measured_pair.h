// The data that the stages of a measurement share: the two meshes, their frame and the directions to measure.
#pragma once

#include <memory>
#include <vector>

#include "engine/bvh.h"
#include "engine/frame.h"
#include "engine/ordered_mesh.h"
#include "engine/outcome.h"
#include "engine/prepared.h"
#include "engine/rounding.h"

namespace meshgauge {

// One of the two meshes. The pointers are null until the build stage sets them; `framed` owns what they point to.
struct MeasuredMesh {
  const Prepared& prepared;
  std::shared_ptr<Framed> framed = nullptr;
  const OrderedMesh* ordered = nullptr;
  const Bvh* tree = nullptr;

  MeshView given() const { return prepared.mesh(); }
};

// One direction: distances from the points of `from` to `to`.
struct MeasuredDirection {
  Directed& result;
  MeasuredMesh& from;
  MeasuredMesh& to;
  bool settled = false;                         // the build stage has found the result
  std::unique_ptr<OrderedMesh> rest = nullptr;  // null: search all of `from`; else only these of its triangles
};

// The largest difference between the meshes at hand and the meshes that they stand for: the sum of both
// Prepared::error(), rounded up, in the meshes' unit. 0: none.
class InputError {
 public:
  InputError(const Prepared& a, const Prepared& b)
      : error_(a.error() > 0 || b.error() > 0 ? rounding::add_up(a.error(), b.error()) : 0) {}

  double value() const { return error_; }

  // The certified interval of the meshes that are stood for, from that of the meshes at hand. An error of 0 changes no
  // bit.
  Bounds widened(Bounds bounds) const {
    if (error_ == 0) return bounds;
    bounds.lower = rounding::subtract_down(bounds.lower, error_);
    bounds.upper = rounding::add_up(bounds.upper, error_);
    return bounds;
  }

  // Upper bound of what widened() adds to the width of an interval, in frame units. It includes the roundings of
  // widened() itself: those of two sums of at most 4.
  double cost(const Frame& frame) const {
    return error_ == 0 ? 0 : 2 * frame.length_to_frame(error_) + 16 * rounding::kUnit;
  }

 private:
  double error_;
};

// `directions` refer to `a` and `b`: not copyable.
struct MeasuredPair {
  MeasuredPair(const Prepared& prepared_a, const Prepared& prepared_b)
      : a{prepared_a}, b{prepared_b}, error(prepared_a, prepared_b) {}
  MeasuredPair(const MeasuredPair&) = delete;
  MeasuredPair& operator=(const MeasuredPair&) = delete;

  MeasuredMesh a;
  MeasuredMesh b;
  InputError error;
  Frame frame;
  std::vector<MeasuredDirection> directions;
};

}  // namespace meshgauge
