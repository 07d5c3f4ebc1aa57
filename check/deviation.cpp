#include "check/deviation.h"

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

#include "api/deviation_csv.h"
#include "api/deviation_glb.h"
#include "api/deviation_maker.h"
#include "api/deviation_ply.h"
#include "api/deviation_vtp.h"
#include "api/refused.h"
#include "check/files.h"
#include "check/manifest/naming.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

bool is_refined(const DeviationFile& file) {
  return file.refine == Refine::always || (file.refine == Refine::by_format && suffix_of(file.path) == ".glb");
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return {ErrorCode::internal, "the deviation map '" + path.string() + "' cannot be written: " + why, "", ""};
}

Result<Done> write_map(const DeviationFile& file, const api::DeviationMap& map, std::ostream& out) {
  const std::string suffix = suffix_of(file.path);
  if (suffix == ".glb") return api::write_deviation_glb(map, out);
  if (suffix == ".csv") return api::write_deviation_csv(map, out), Done{};
  if (suffix == ".vtp") return api::write_deviation_vtp(map, out), Done{};
  return api::write_deviation_ply(map, out), Done{};
}

Result<Done> write_whole(const DeviationFile& file, const api::DeviationMap& map) {
  StagedFile staged(file.path);
  errno = 0;
  std::ofstream out(staged.path(), std::ios::binary);
  const auto written = write_map(file, map, out);
  out.close();
  const int number = errno;
  if (!written) return written;
  if (!out) return cannot_write(file.path, number ? std::generic_category().message(number) : "the stream failed");
  if (const auto failed = staged.put()) return cannot_write(file.path, failed.message());
  return Done{};
}

}  // namespace

Result<Done> check_deviation_name(const fs::path& path) {
  const std::string suffix = suffix_of(path);
  for (const char* known : {".ply", ".glb", ".vtp", ".csv"}) {
    if (suffix == known) return Done{};
  }
  return bad_flag("--deviation", "the file must end in .ply, .glb, .vtp or .csv, not '" + path.string() + "'");
}

Result<Done> write_deviation(const DeviationFile& file, const Prepared& candidate, const Prepared& baseline,
                             const api::ResultFacts& facts, Control& control) {
  if (auto ok = check_deviation_name(file.path); !ok) return ok;
  api::MapOptions options;
  options.refine = is_refined(file);
  options.threads = file.threads;
  const auto made = api::make_deviation(candidate, baseline, facts, options, control);
  if (!made) return made.error();
  return write_whole(file, made->map());
}

}  // namespace meshgauge::check
