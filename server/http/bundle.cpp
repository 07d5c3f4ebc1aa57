#include "server/http/bundle.h"

#include <algorithm>

#include "api/formats/gltf/gltf_bundle.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

std::uint64_t archive_bytes(const std::vector<SentFile>& files) {
  std::uint64_t bytes = api::BundleWriter::bytes_for_end();
  for (const SentFile& file : files) bytes += api::BundleWriter::bytes_for(file.path, file.upload->size());
  return bytes;
}

}  // namespace

std::uint64_t bytes_of(const MeshField& field) {
  std::uint64_t bytes = field.upload ? field.upload->size() : 0;
  for (const SentFile& file : field.files) bytes += file.upload->size();
  return bytes;
}

std::optional<Problem> combine_files(MeshField& field, std::uint64_t most, const UploadShare& share,
                                     const std::string& temp_dir) {
  if (field.files.empty()) return std::nullopt;
  const std::string& name = field.head.name;
  if (!api::is_gltf_json(field.upload->bytes())) {
    return field_problem(ProblemKind::malformed_request, name,
                         "the part '" + name + "' is not a .gltf document, so no part '" + name +
                             ".files' may be sent with it; send a mesh of one file without them");
  }
  std::vector<SentFile> files = std::move(field.files);
  files.push_back({std::string(api::kBundleScene), std::move(field.upload)});
  std::ranges::sort(files, {}, &SentFile::path);
  const std::uint64_t limit = std::min(most, api::kMostBundleBytes);
  if (archive_bytes(files) > limit) {
    return field_problem(
        ProblemKind::too_large, name,
        "the part '" + name + "' with its files is larger than the limit of " + std::to_string(limit) + " bytes");
  }
  auto archive = std::make_unique<Upload>(share, temp_dir);
  std::optional<Problem> refusal;
  api::BundleWriter writer([&](std::string_view piece) { return !(refusal = archive->append(piece)); });
  for (SentFile& file : files) {
    if (!writer.add(file.path, file.upload->bytes())) return refusal;
    file.upload.reset();
  }
  if (!writer.finish()) return refusal;
  field.upload = std::move(archive);
  return field.upload->finish();
}

}  // namespace meshgauge::server
