// A measurement of a pair with errors of the input, which may be cancelled.
#pragma once

#include <cstdint>
#include <optional>

#include "engine/hausdorff.h"
#include "engine/tree/prepared.h"

namespace meshgauge::fuzz {

struct Asked {
  Options options;
  std::uint64_t cancel_at = 0;  // 0: never
  // The meshes that are measured stand for those of the pair, with these errors.
  Mesh a, b;
  double error_a = 0, error_b = 0;
};

inline Outcome run(const Asked& asked, unsigned threads) {
  Control control;
  if (asked.cancel_at) control.cancel_at_check(asked.cancel_at);
  Options options = asked.options;
  options.threads = threads;
  const auto prepared = [](const Mesh& mesh, double error) {
    return Prepared(mesh, Prepared::Use::once, nullptr, std::nullopt, error);
  };
  return measure(prepared(asked.a, asked.error_a), prepared(asked.b, asked.error_b), options, control);
}

}  // namespace meshgauge::fuzz
