// Trees for tests, built at once and without an end in time.
#pragma once

#include "engine/bvh.h"

namespace meshgauge {

// Over `mesh` as it is, which must outlive the tree.
inline Bvh tree_of(MeshView mesh, const Kernels& kernels = *find_kernels("auto")) {
  Control control;
  ThreadPool pool(1);
  return Bvh(mesh, kernels, control, pool);
}

}  // namespace meshgauge
