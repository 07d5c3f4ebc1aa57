// tinyobjloader as a peer of our OBJ reader: the same triangles by independent code. Used by tests only.
#pragma once

#include <cstdint>
#include <string_view>

#include "engine/mesh.h"

namespace meshgauge::api::test {

// Returns the mesh as its callbacks report it, unchecked: an index may name no vertex. Faces are split by our rule, as
// far as all indices name vertices, and at our positions: at theirs, a few roundings away, the rule may choose other
// triangles.
Mesh by_tinyobj(std::string_view text, const std::vector<Vec3>& positions);

// In words, why tinyobjloader may see another mesh in this text than a reader of the format; empty when it must see
// the same. Each is a limit of its own, found in its version 2.0.0rc10.
std::string_view tinyobj_excuse(std::string_view text);

// How many doubles lie between a and b. tinyobjloader rounds at every digit, so its numbers are not strtod's: within
// 4 of them for what exporters write, within kMostTinyobjSteps for anything that it has no excuse for.
std::uint64_t steps_apart(double a, double b);
inline constexpr std::uint64_t kMostTinyobjSteps = 20;  // 25 digits of half a step each, and a power

}  // namespace meshgauge::api::test
