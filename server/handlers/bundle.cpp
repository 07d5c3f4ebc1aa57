#include "server/handlers/bundle.h"

#include <algorithm>

#include "api/formats/gltf_bundle.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

std::uint64_t archive_bytes(const std::vector<SentFile>& files) {
  std::uint64_t bytes = api::BundleWriter::bytes_for_end();
  for (const SentFile& file : files) bytes += api::BundleWriter::bytes_for(file.path, file.upload->size());
  return bytes;
}

Problem about(const MeshPart& part, ProblemKind kind, const std::string& what) {
  return Problem{kind, what, {{part.head.name, "", what}}};
}

}  // namespace

std::uint64_t bytes_of(const MeshPart& part) {
  std::uint64_t bytes = part.upload ? part.upload->size() : 0;
  for (const SentFile& file : part.files) bytes += file.upload->size();
  return bytes;
}

std::optional<Problem> put_together(MeshPart& part, std::uint64_t most, ByteBudget& budget,
                                    const std::string& temp_dir) {
  if (part.files.empty()) return std::nullopt;
  const std::string& name = part.head.name;
  if (!api::is_gltf_json(part.upload->bytes())) {
    return about(part, ProblemKind::malformed_request,
                 "the part '" + name + "' is no .gltf, and the parts '" + name +
                     ".files' go with one: send a mesh of "
                     "one file without them");
  }
  std::vector<SentFile> files = std::move(part.files);
  files.push_back({std::string(api::kBundleScene), std::move(part.upload)});
  std::ranges::sort(files, {}, &SentFile::path);
  const std::uint64_t limit = std::min(most, api::kMostBundleBytes);
  if (archive_bytes(files) > limit) {
    return about(
        part, ProblemKind::too_large,
        "the part '" + name + "' with its files is larger than the limit of " + std::to_string(limit) + " bytes");
  }
  auto archive = std::make_unique<Upload>(budget, temp_dir);
  std::optional<Problem> refusal;
  api::BundleWriter writer([&](std::string_view piece) { return !(refusal = archive->append(piece)); });
  for (SentFile& file : files) {
    if (!writer.add(file.path, file.upload->bytes())) return refusal;
    file.upload.reset();
  }
  if (!writer.finish()) return refusal;
  part.upload = std::move(archive);
  return part.upload->finish();
}

}  // namespace meshgauge::server
