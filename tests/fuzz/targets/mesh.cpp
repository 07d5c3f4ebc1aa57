// The target of a mesh format: one for each line of mesh_target() in CMakeLists.txt, which names the format.
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  meshgauge::fuzz::check_file_of(MESHGAUGE_FUZZ_FORMAT, meshgauge::fuzz::text_of(data, size));
  return 0;
}
