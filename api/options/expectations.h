// What is expected of mesh a itself, beside its distance to mesh b.
#pragma once

#include <optional>

namespace meshgauge::api {

// Both ends are part of it; nullopt: no end.
struct Span {
  std::optional<double> min, max;

  bool operator==(const Span&) const = default;
};

// nullopt: nothing is expected.
struct Expectations {
  std::optional<bool> watertight, oriented;
  std::optional<Span> triangles, degenerate, components;
  std::optional<Span> volume;           // in the cube of the unit of the result
  std::optional<double> volume_within;  // of mesh b's volume: 0.01 is one percent

  bool operator==(const Expectations&) const = default;
  bool any() const { return *this != Expectations(); }
  // Whether the comparison has to examine the topology of the meshes.
  bool of_topology() const { return watertight || oriented || components || volume || volume_within; }
};

}  // namespace meshgauge::api
