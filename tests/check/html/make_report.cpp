// Writes the HTML report of some gates: for the tests that open it in a browser, and for eyes.
//
//   make_report OUT.html FOLDER                     of gates made here, one of each kind, hostile names among them
//   make_report OUT.html A B LIMIT [A B LIMIT ...]  of these files
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>

#include "api/base/machine.h"
#include "check/criteria.h"
#include "check/html/gallery.h"
#include "check/html/html.h"
#include "check/run/local.h"
#include "check/run/run.h"
#include "shapes.h"

namespace {

using namespace meshgauge;

check::Gate gate(const std::string& name, const std::string& candidate, const std::string& baseline, double limit) {
  check::Gate made;
  made.name = name;
  made.candidate = candidate;
  made.baseline = baseline;
  check::set_limit(made, limit, api::LengthUnit::millimeter);
  return made;
}

std::string write_off(const std::filesystem::path& path, const Mesh& mesh) {
  std::ofstream file(path);
  file.precision(17);
  file << "OFF\n" << mesh.positions.size() << " " << mesh.triangles.size() << " 0\n";
  for (const Vec3& p : mesh.positions) file << p.x() << " " << p.y() << " " << p.z() << "\n";
  for (const Triangle& t : mesh.triangles) file << "3 " << t[0] << " " << t[1] << " " << t[2] << "\n";
  return path.string();
}

// A sphere with a dent at its front.
Mesh dented(std::uint32_t rings) {
  Mesh mesh = shapes::sphere(rings, 10);
  const Vec3 at(8, -5, 3.3);
  for (Vec3& p : mesh.positions) {
    const double share = (p - at).norm() / 3;
    if (share < 1) p *= 1 - 0.06 * (1 - share) * (1 - share);
  }
  return mesh;
}

Mesh with_hole(Mesh mesh, const Vec3& at, double radius) {
  std::erase_if(mesh.triangles, [&](const Triangle& t) {
    return ((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3 - at).norm() < radius;
  });
  return mesh;
}

constexpr std::uint32_t kRings = 48;  // of spheres

std::vector<check::Gate> one_of_each(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const auto file = [&](const char* name, const Mesh& mesh) { return write_off(folder / name, mesh); };
  const std::string round = file("round.off", shapes::sphere(kRings, 10));
  const std::string dent = file("dent.off", dented(kRings));
  const std::string hole = file("hole.off", with_hole(shapes::sphere(kRings, 10), Vec3(6, -6, 5), 1.4));
  const std::string block = file("block.off", shapes::cube(20, Vec3(1e6, 1e6, 0)));
  const std::string moved = file("moved.off", shapes::moved(shapes::cube(20, Vec3(1e6, 1e6, 0)), Vec3(0.05, 0, 0)));
  const std::string flat = file("flat.off", shapes::grid(3, 30));
  const std::string point = file("point.off", shapes::triangle(Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)));
  const std::string hostile = file("<b>&'\".off", shapes::grid(3, 30, 0.02));

  std::vector<check::Gate> gates{gate("dent", dent, round, 0.1), gate("hole", hole, round, 0.05),
                                 gate("round", round, dent, 1), gate("block far from the origin", moved, block, 0.02)};
  gates.push_back(
      gate("</h2><script>alert(1)</script> \"quoted\" & 'quoted' \xE2\x80\xAE \xFF \x01", hostile, flat, 0.5));
  gates.push_back(gate("missing <file>", (folder / "missing <b>.off").string(), round, 1));
  gates.push_back(gate("share of the diagonal", dent, round, 0));
  check::set_share_of_diagonal(gates.back(), 0.0125);
  gates.push_back(gate("equal, with a limit of 0", round, round, 0));
  gates.push_back(gate("a single point", point, round, 30));
  gates.push_back(gate("only warns", dent, round, 0.3));
  gates.back().warn_only = true;
  gates.push_back(gate("undecided", dent, round, 0.58));
  gates.back().request.options.tolerance = {100, std::nullopt, std::nullopt};
  gates.push_back(gate("area", dent, round, 1));
  gates.back().request.options.max_share_beyond = api::ShareLimit{0.2, 0.02};
  gates.push_back(gate("area alone", dent, round, 0));
  check::set_area_limit(gates.back(), {0.1, 0.01});
  for (check::Gate& each : gates) {
    each.manifest = "gates.yaml";
    each.line = 7;
    each.request.options.statistics.emplace();
  }
  return gates;
}

std::vector<check::Gate> of_files(int count, char** arguments) {
  std::vector<check::Gate> gates;
  for (int i = 0; i + 2 < count; i += 3) {
    const std::filesystem::path candidate = arguments[i];
    gates.push_back(gate(candidate.filename().string(), arguments[i], arguments[i + 1], std::atof(arguments[i + 2])));
  }
  return gates;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) return 64;
  const auto gates = count == 3 ? one_of_each(arguments[2]) : of_files(count - 2, arguments + 2);
  const unsigned processors = api::processors();
  const auto meshes = std::make_shared<check::Meshes>(gates, 2);
  const auto measurer = check::local(gates, meshes, {processors, 0});
  check::Gallery gallery(meshes, gates.size(), true);
  check::Watch watch;
  watch.after = [&](std::size_t, const check::GateOutcome& outcome, Control& control) {
    gallery.draw(outcome, false, 1, control);
  };
  const check::Report report = check::run(gates, *measurer, watch);
  const auto pictures = gallery.end(report, processors, never_interrupted);
  std::ofstream(arguments[1], std::ios::binary) << to_html(report, pictures);
  for (const check::GateOutcome& outcome : report.outcomes) {
    std::printf("%s\t%s\n", std::string(to_string(outcome.verdict())).c_str(), outcome.gate.name.c_str());
  }
  return 0;
}
