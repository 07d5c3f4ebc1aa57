// Compressed glTF files made by the tests: the tetrahedron, by the encoders of libdraco and libmeshoptimizer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace meshgauge::api::test {

// A Draco stream of these triangles. Attribute 0: positions, of `bits` bits, or unquantized for 0. `speed` 10 encodes
// the triangles one after the other, others by their edges.
std::string draco_stream(const std::vector<float>& positions, const std::vector<std::uint32_t>& corners, int bits,
                         int speed);

// GLB files.
std::string draco_glb(const std::string& stream);
std::string meshopt_glb(const std::string& extension);

}  // namespace meshgauge::api::test
