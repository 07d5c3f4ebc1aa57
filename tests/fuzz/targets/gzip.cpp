// gzip around a mesh file: the input is a gzip file, or a file to be compressed here, since no mutation of a compressed
// file passes its checksum.
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

FUZZ_TARGET(gzip) {
  const auto file = meshgauge::fuzz::text_of(data, size);
  meshgauge::fuzz::check_mesh_file(file, "m.obj.gz");
  meshgauge::fuzz::check_compressed(file);
  return 0;
}
