// Trees for tests, built on one thread and without a deadline.
#pragma once

#include "engine/tree/bvh.h"

namespace meshgauge {

// Returns a tree over `mesh`, which must outlive it.
inline Bvh tree_of(MeshView mesh, const Kernels& kernels = *find_kernels("auto")) {
  Control control;
  ThreadPool pool(1);
  return Bvh(mesh, kernels, control, pool);
}

}  // namespace meshgauge
