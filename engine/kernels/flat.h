// Copies single triangles out of and into the lanes of a block.
#pragma once

#include "engine/kernels/layout.h"

namespace meshgauge {

inline FlatTriangle flat(const TriangleBlock& block, std::size_t lane) {
  FlatTriangle t;
  for (std::size_t k = 0; k < 3; ++k) {
    t.a[k] = block.a[k][lane];
    t.e1[k] = block.e1[k][lane];
    t.e2[k] = block.e2[k][lane];
  }
  t.length = block.length[lane];
  t.cx = block.cx[lane];
  t.cy = block.cy[lane];
  return t;
}

inline void store(const FlatTriangle& t, TriangleBlock& block, std::size_t lane) {
  for (std::size_t k = 0; k < 3; ++k) {
    block.a[k][lane] = t.a[k];
    block.e1[k][lane] = t.e1[k];
    block.e2[k][lane] = t.e2[k];
  }
  block.length[lane] = t.length;
  block.cx[lane] = t.cx;
  block.cy[lane] = t.cy;
}

}  // namespace meshgauge
