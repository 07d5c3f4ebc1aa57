// 3MF: the input is a package, or the model of one that is put together here, since no mutation leaves the checksums of
// an archive right.
#include <string>

#include "tests/api/formats/zip_files.h"
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string input(meshgauge::fuzz::text_of(data, size));
  meshgauge::fuzz::check_file_of("3mf", input.starts_with("PK") ? input : meshgauge::api::test::package(input));
  return 0;
}
