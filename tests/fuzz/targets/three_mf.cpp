// 3MF: the input is a package, or the parts of one that is put together here, since no mutation leaves the checksums of
// an archive right: the model and, each behind a NUL, the slicers' notes about its volumes.
#include <algorithm>
#include <string>
#include <vector>

#include "tests/api/formats/zip_files.h"
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

FUZZ_TARGET(3mf) {
  using namespace meshgauge;
  const std::string input(fuzz::text_of(data, size));
  if (input.starts_with("PK")) return fuzz::check_file_of("3mf", input), 0;
  std::size_t at = std::min(input.find('\0'), input.size());
  const std::string model = input.substr(0, at);
  std::vector<api::test::ZipEntry> notes;
  for (const char* name : {"Metadata/Slic3r_PE_model.config", "Metadata/model_settings.config"}) {
    if (at == input.size()) break;
    const std::size_t next = std::min(input.find('\0', at + 1), input.size());
    notes.push_back({name, input.substr(at + 1, next - at - 1)});
    at = next;
  }
  fuzz::check_file_of("3mf", api::test::package(model, notes));
  return 0;
}
