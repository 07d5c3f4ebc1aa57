#include "check/deviation.h"

#include <cerrno>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>

#include "api/deviation_glb.h"
#include "api/deviation_maker.h"
#include "api/deviation_ply.h"
#include "api/digest.h"
#include "check/manifest/naming.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

bool is_refined(const DeviationFile& file) {
  return file.refine == Refine::always || (file.refine == Refine::by_format && suffix_of(file.path) == ".glb");
}

std::optional<api::DeviationWitness> witness_of(const Measured& measured) {
  if (!measured.witness) return std::nullopt;
  const Witness& w = *measured.witness;
  return api::DeviationWitness{w.on_candidate, w.from, w.from_triangle, w.to, w.to_triangle};
}

// What the document says of the way from the candidate; nothing when that direction was not measured.
std::optional<api::DeviationDirection> direction_of(const Measured& measured) {
  if (!measured.document.is_object()) return std::nullopt;
  const auto facts = api::deviation_facts(measured.document.dump(), api::Side::a);
  return facts ? facts->direction : std::nullopt;
}

Error cannot_write(const fs::path& path, const std::string& why) {
  return {ErrorCode::internal, "the deviation map '" + path.string() + "' cannot be written: " + why, "", ""};
}

Result<Done> write_map(const DeviationFile& file, const api::DeviationMap& map, std::ostream& out) {
  if (suffix_of(file.path) == ".glb") return api::write_deviation_glb(map, out);
  return api::write_deviation_ply(map, out), Done{};
}

Result<Done> write_whole(const DeviationFile& file, const api::DeviationMap& map) {
  // A name of its own: other runs may write the same map, and nobody's file is in the way.
  const fs::path part = file.path.parent_path() / (".meshgauge-" + api::random_id() + ".part");
  errno = 0;
  std::ofstream out(part, std::ios::binary);
  auto written = write_map(file, map, out);
  out.close();
  const int number = errno;
  std::error_code failed;
  if (written && out) {
    fs::rename(part, file.path, failed);
    if (!failed) return written;
  }
  const std::string unwritten = number != 0 ? std::generic_category().message(number) : "the stream failed";
  const std::string why = failed ? failed.message() : unwritten;
  std::error_code ignored;
  fs::remove(part, ignored);
  return written ? cannot_write(file.path, why) : written;
}

}  // namespace

Result<Done> check_deviation_name(const fs::path& path) {
  const std::string suffix = suffix_of(path);
  if (suffix == ".ply" || suffix == ".glb") return Done{};
  return Error{ErrorCode::invalid_request, "a deviation map ends in .ply or .glb, not '" + path.string() + "'", "",
               "--deviation"};
}

Result<Done> write_deviation(const DeviationFile& file, const Prepared& candidate, const Prepared& baseline,
                             const Measured& measured, Control& control) {
  if (auto ok = check_deviation_name(file.path); !ok) return ok;
  const auto& unit = measured.units.result.unit;
  const api::DeviationFacts facts{measured.limit,       unit ? std::string(api::to_string(*unit)) : std::string(),
                                  measured.lower,       measured.upper,
                                  witness_of(measured), direction_of(measured),
                                  measured.units};
  api::MapOptions options;
  options.refine = is_refined(file);
  options.threads = file.threads;
  const auto made = api::make_deviation(candidate, baseline, facts, options, control);
  if (!made) return made.error();
  return write_whole(file, made->map());
}

}  // namespace meshgauge::check
