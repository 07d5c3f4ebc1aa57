// A zip archive of a glTF: the input is an archive, or the JSON of a .gltf and, behind a NUL, the bytes of each of the
// files x.bin and sub/y.bin of one that is put together here, since no mutation leaves the checksums of an archive
// right.
#include <algorithm>
#include <string>

#include "api/formats/gltf/gltf_bundle.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/mesh_file.h"
#include "tests/fuzz/targets/target.h"

namespace {

std::string archive(std::string_view json, std::string_view data) {
  using meshgauge::api::BundleWriter;
  std::string out;
  BundleWriter writer([&](std::string_view piece) { return out += piece, true; });
  std::uint64_t bytes = BundleWriter::bytes_for_end();
  const auto add = [&](std::string_view path, std::string_view content) {
    writer.add(path, std::as_bytes(std::span<const char>(content)));
    bytes += BundleWriter::bytes_for(path, content.size());
  };
  add(meshgauge::api::kBundleScene, json);
  add("sub/y.bin", data.substr(data.size() / 2));
  add("x.bin", data);
  writer.finish();
  meshgauge::fuzz::require(out.size() == bytes, "an archive is as large as was said before");
  return out;
}

}  // namespace

FUZZ_TARGET(gltf_zip) {
  const auto input = meshgauge::fuzz::text_of(data, size);
  const std::size_t nul = std::min(input.find('\0'), input.size());
  const std::string file = input.starts_with("PK")
                               ? std::string(input)
                               : archive(input.substr(0, nul), input.substr(std::min(nul + 1, input.size())));
  meshgauge::fuzz::check_file_of("gltf", file);
  return 0;
}
