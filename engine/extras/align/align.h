// Rigid alignment: the motion that brings one mesh nearest to another, in the sense of least squares.
//
// Samples of the moved mesh, stratified by area with a fixed seed, look for their closest points on the fixed mesh. A
// step is the velocity v of a rigid motion that minimises the sum over the samples of (d + n.v)^2 + m |v|^2, d a
// sample's distance and n its direction: Gauss and Newton's method on the distances, which is point to plane on the
// faces, with Levenberg's damping m. A step that raises the residual is taken back, and m grows.
//
// This is a search for a good motion and certifies nothing: what is certified is the distance after the motion found.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "engine/control.h"
#include "engine/mesh/rigid.h"
#include "engine/tree/prepared.h"

namespace meshgauge {

struct AlignOptions {
  RigidMotion start;            // from the pose as given
  bool fit = true;              // false: `start` is the answer
  bool principal_axes = false;  // also from the 24 poses that lay the principal axes of both meshes on each other
  // The share of the samples that count, from 0 to 1: the nearest ones. Less than 1 where a part of the moved mesh has
  // no counterpart.
  double overlap = 1;

  bool operator==(const AlignOptions&) const = default;
};

struct Alignment {
  RigidMotion motion;
  double before = 0;    // residual at AlignOptions::start, in the meshes' unit
  double residual = 0;  // root mean square of the distances of the samples that count
  bool converged = true;
  int steps = 0;   // tried from the start that won
  int starts = 0;  // 0: nothing was fitted
  std::size_t samples = 0;
};

// Aligns `moving` to `fixed`. Where `fixed` alone is a cloud, its points are the samples. The result depends on neither
// the number of threads nor the instruction set. nullopt: interrupted; nothing half done is returned. Preconditions:
// both meshes pass validate(); overlap is in (0, 1].
std::optional<Alignment> align(const Prepared& moving, const Prepared& fixed, const AlignOptions& options,
                               unsigned threads, std::string_view simd, Control& control);

}  // namespace meshgauge
