// The targets of mesh formats that need no more than a file.
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

namespace {

int check(const char* format, const std::uint8_t* data, std::size_t size) {
  meshgauge::fuzz::check_file_of(format, meshgauge::fuzz::text_of(data, size));
  return 0;
}

}  // namespace

FUZZ_TARGET(obj) { return check("obj", data, size); }
FUZZ_TARGET(stl) { return check("stl", data, size); }
FUZZ_TARGET(ply) { return check("ply", data, size); }
FUZZ_TARGET(off) { return check("off", data, size); }
FUZZ_TARGET(gltf) { return check("gltf", data, size); }
FUZZ_TARGET(xyz) { return check("xyz", data, size); }
