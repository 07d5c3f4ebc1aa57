#include "check/deviation.h"

#include <cerrno>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>

#include "api/deviation_glb.h"
#include "api/deviation_map.h"
#include "api/deviation_ply.h"
#include "api/digest.h"
#include "api/load.h"
#include "check/manifest/naming.h"
#include "engine/deviation.h"
#include "engine/refinement.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

constexpr double kLongestEdge = 1.0 / 64;  // of the diagonal
constexpr std::size_t kMostTriangles = 250'000;

bool is_refined(const DeviationFile& file) {
  return file.refine == Refine::always || (file.refine == Refine::by_format && suffix_of(file.path) == ".glb");
}

std::optional<Mesh> refined_for_display(const Prepared& candidate, Control& control) {
  return refined(candidate.mesh(), {kLongestEdge * diagonal(candidate.box()), kMostTriangles},
                 [&control] { return control.check() != Interruption::none; });
}

std::optional<api::DeviationWitness> witness_of(const Measured& measured) {
  if (!measured.witness) return std::nullopt;
  const Witness& w = *measured.witness;
  return api::DeviationWitness{w.on_candidate, w.from, w.from_triangle, w.to, w.to_triangle};
}

// Of the candidate's points to the baseline; infinite when that direction was not measured.
double certified_upper(const Measured& measured) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (!measured.document.is_object()) return kNone;
  const nlohmann::ordered_json directed = measured.document.value("a_to_b", nlohmann::ordered_json());
  if (!directed.is_object()) return kNone;
  const auto upper = directed.find("upper");
  const bool bound = upper != directed.end() && upper->is_number() && upper->get<double>() >= 0;
  return bound ? upper->get<double>() : kNone;
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
                             const Gate& gate, const Measured& measured, Control& control) {
  if (auto ok = check_deviation_name(file.path); !ok) return ok;
  const auto more = is_refined(file) ? refined_for_display(candidate, control) : std::nullopt;
  std::optional<Prepared> display;
  if (more) display.emplace(*more);
  const Prepared& from = display ? *display : candidate;
  const auto deviations = deviation(from, baseline, {file.threads, "auto", certified_upper(measured)}, control);
  if (!deviations) return api::not_in_time(control.check(), "the deviation map was made");
  return write_whole(file, {from.mesh(),
                            candidate.mesh().positions.size(),
                            candidate.mesh().triangles.size(),
                            deviations->distances,
                            {measured.limit, true},
                            gate.limit.units,
                            measured.lower,
                            measured.upper,
                            witness_of(measured)});
}

}  // namespace meshgauge::check
