// Files of any kind under no name: the content alone tells what they are, compressed or not.
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

FUZZ_TARGET(detect) {
  meshgauge::fuzz::check_mesh_file(meshgauge::fuzz::text_of(data, size), "");
  return 0;
}
