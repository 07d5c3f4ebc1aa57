// What a stand-in for the comparison answers: it was given these options, and never looked at the meshes.
#pragma once

#include "api/compare.h"
#include "server/jobs/mesh_source.h"

namespace meshgauge::server {

inline api::Comparison stand_in(const MeshSource& a, const api::ComparisonOptions& options) {
  api::Comparison comparison;
  comparison.options = options;
  comparison.outcome.simd = options.simd;
  comparison.outcome.threads = options.threads;
  comparison.a.bytes = a.input.bytes.size();
  comparison.a.bbox.extend(Vec3::Zero());
  comparison.b.bbox.extend(Vec3::Zero());
  return comparison;
}

}  // namespace meshgauge::server
