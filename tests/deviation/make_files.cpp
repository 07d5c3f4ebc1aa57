// Deviation maps for the readers of other programs, and beside each what must be found in it: NAME.ply, NAME.glb,
// NAME.json in the folder given.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "api/map/colour_map.h"
#include "check/deviation.h"
#include "engine/extras/display/deviation.h"
#include "shapes.h"

using namespace meshgauge;
using nlohmann::json;

namespace {

struct Case {
  const char* name;
  Mesh candidate;
  Mesh baseline;
  double limit;
};

json expected(const Case& made) {
  const Prepared candidate(made.candidate), baseline(made.baseline);
  Control control;
  const auto found = deviation(candidate, baseline, {}, control);
  json facts{{"limit", made.limit}, {"triangles", made.candidate.triangles}, {"distance", found->distances}};
  for (const Vec3& p : made.candidate.positions) facts["positions"].push_back({p.x(), p.y(), p.z()});
  for (const double distance : found->distances) {
    const api::Rgb c = api::colour_of(distance, {made.limit, true});
    facts["colours"].push_back({c.red, c.green, c.blue});
  }
  return facts;
}

bool write(const Case& made, const std::filesystem::path& folder) {
  const Prepared candidate(made.candidate), baseline(made.baseline);
  api::ResultFacts facts;
  facts.units.result = {api::LengthUnit::millimeter, api::UnitSource::declared};
  facts.limit = {{made.limit}};
  facts.upper = 2 * made.limit;
  facts.witness = api::ResultWitness{true, made.candidate.positions[0], 0, made.baseline.positions[0], 0};
  for (const char* suffix : {".ply", ".glb"}) {
    Control control;
    const check::DeviationFile file{folder / (std::string(made.name) + suffix), check::Refine::never, 1};
    const auto written = check::write_deviation(file, candidate, baseline, facts, control);
    if (!written) return std::fprintf(stderr, "%s\n", written.error().message.c_str()), false;
  }
  return bool(std::ofstream(folder / (std::string(made.name) + ".json")) << expected(made));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::filesystem::create_directories(argv[1]);
  const Mesh egg = shapes::sphere(12, 1.0625);
  const Vec3 far_away(2e6, -3e6 + 1.0 / 3, 0);
  for (const Case& made : {Case{"egg", egg, shapes::sphere(20, 1, {0.1, 0, 0}), 0.1},
                           Case{"far", shapes::moved(egg, far_away), shapes::moved(shapes::sphere(20), far_away), 0.06},
                           Case{"grid", shapes::grid(200), shapes::grid(3, 1, 0.25), 0.5}}) {
    if (!write(made, argv[1])) return 1;
  }
}
