#include "check/deviation.h"

#include <cerrno>
#include <fstream>
#include <string>

#include "api/base/refused.h"
#include "api/map/deviation_maker.h"
#include "check/files.h"
#include "check/manifest/naming.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

Result<api::MapKind> kind_of(const fs::path& path) {
  const std::string suffix = suffix_of(path);
  for (const auto& format : api::kMapFormats) {
    if (suffix == "." + std::string(format.name)) return format.kind;
  }
  return bad_flag("--deviation", "the file must end in .ply, .glb, .vtp or .csv, not '" + path.string() + "'");
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return {ErrorCode::internal, "the deviation map '" + path.string() + "' cannot be written: " + why, "", ""};
}

Result<Done> write_whole(const DeviationFile& file, const api::DeviationMap& map, api::MapKind kind) {
  StagedFile staged(file.path);
  errno = 0;
  std::ofstream out(staged.path(), std::ios::binary);
  const auto written = api::write_deviation(map, kind, out);
  out.close();
  const int number = errno;
  if (!written) return written;
  if (!out) return cannot_write(file.path, number ? std::generic_category().message(number) : "the stream failed");
  if (const auto failed = staged.put()) return cannot_write(file.path, failed.message());
  return Done{};
}

}  // namespace

Result<Done> check_deviation_name(const fs::path& path) {
  const auto kind = kind_of(path);
  return kind ? Result<Done>(Done{}) : kind.error();
}

Result<Done> write_deviation(const DeviationFile& file, const Prepared& candidate, const Prepared& baseline,
                             const api::ResultFacts& facts, Control& control) {
  const auto kind = kind_of(file.path);
  if (!kind) return kind.error();
  api::MapOptions options;
  options.refine = file.refine == Refine::by_format ? is_for_viewing(*kind) : file.refine == Refine::always;
  options.threads = file.threads;
  options.normals = file.normals;
  const auto made = api::make_deviation(candidate, baseline, facts, options, control);
  if (!made) return made.error();
  return write_whole(file, made->map(), *kind);
}

}  // namespace meshgauge::check
