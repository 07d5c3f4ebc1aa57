#include "check/deviation.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "api/formats/format.h"
#include "engine/hausdorff.h"
#include "shapes.h"

using namespace meshgauge;
namespace fs = std::filesystem;

namespace {

// A folder of its own, gone with it.
class MapFolder {
 public:
  MapFolder() {
    std::string name = (fs::temp_directory_path() / "meshgauge-deviation-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~MapFolder() { fs::remove_all(path_); }
  MapFolder(const MapFolder&) = delete;
  MapFolder& operator=(const MapFolder&) = delete;

  const fs::path& path() const { return path_; }
  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), {})); }

 private:
  fs::path path_;
};

std::string content(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Mesh read(const fs::path& path) {
  const std::string file = content(path);
  auto result = api::read_mesh(std::as_bytes(std::span<const char>(file)), {"a", path.string(), ""}, {});
  INFO((result ? "" : result.error().message));
  REQUIRE(result.ok());
  return std::move(result->mesh);
}

// The property "distance" of a PLY of ours: the last of a vertex.
std::vector<double> distances_of(const fs::path& path) {
  const std::string file = content(path), counted = "\nelement vertex ", ended = "\nend_header\n";
  std::vector<double> distances(std::stoul(file.substr(file.find(counted) + counted.size())));
  const bool wide = file.find("\nproperty double x\n") != std::string::npos;
  const std::size_t size = 3 * (wide ? sizeof(double) : sizeof(float)) + 3 + sizeof(float) + sizeof(double);
  const std::size_t begin = file.find(ended) + ended.size();
  REQUIRE(begin + distances.size() * size <= file.size());
  for (std::size_t v = 0; v < distances.size(); ++v) {
    std::memcpy(&distances[v], file.data() + begin + (v + 1) * size - sizeof(double), sizeof(double));
  }
  return distances;
}

Result<Done> write(const check::DeviationFile& file, const Mesh& candidate, Control& control) {
  const Mesh baseline = shapes::cube(1, {0, 0, 0.1});
  const Prepared a(candidate), b(baseline);
  api::ResultFacts facts;
  facts.units.result = {api::LengthUnit::centimeter, api::UnitSource::declared};
  facts.limit = {{0.05}};
  facts.lower = 0.1;
  facts.upper = 0.2;
  return check::write_deviation(file, a, b, facts, control);
}

}  // namespace

TEST_CASE("deviation: the suffix decides the format, in any case") {
  const MapFolder folder;
  Control control;
  for (const char* name : {"map.ply", "map.PLY"}) {
    REQUIRE(write({folder.path() / name}, shapes::cube(), control).ok());
    CHECK(content(folder.path() / name).starts_with("ply\n"));
  }
  for (const char* name : {"map.glb", "map.Glb"}) {
    REQUIRE(write({folder.path() / name}, shapes::cube(), control).ok());
    CHECK(content(folder.path() / name).starts_with("glTF"));
  }
  REQUIRE(write({folder.path() / "map.csv"}, shapes::cube(), control).ok());
  CHECK(content(folder.path() / "map.csv").starts_with("x,y,z,distance\n"));
  REQUIRE(write({folder.path() / "map.vtp"}, shapes::cube(), control).ok());
  CHECK(content(folder.path() / "map.vtp").starts_with("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\""));
  for (const char* name : {"map.obj", "map", "ply", "map.ply.txt"}) {
    CHECK_FALSE(check::check_deviation_name(name).ok());
    const auto refused = write({folder.path() / name}, shapes::cube(), control);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::invalid_request);
    CHECK(refused.error().message.find(name) != std::string::npos);
  }
}

TEST_CASE("deviation: a PLY has the candidate's vertices, a GLB is refined for display by default") {
  const MapFolder folder;
  Control control;
  const fs::path ply = folder.path() / "map.ply", glb = folder.path() / "map.glb";
  REQUIRE(write({ply}, shapes::cube(), control).ok());
  CHECK(read(ply).positions == shapes::cube().positions);
  CHECK(content(ply).find("\ncomment unit cm\n") != std::string::npos);
  REQUIRE(write({glb}, shapes::cube(), control).ok());
  const Mesh fine = read(glb);
  CHECK(fine.triangles.size() > 10'000);
  CHECK(fine.triangles.size() <= 250'000);
  CHECK(std::equal(fine.positions.begin(), fine.positions.begin() + 8, shapes::cube().positions.begin()));

  REQUIRE(write({ply, check::Refine::always}, shapes::cube(), control).ok());
  CHECK(read(ply).triangles.size() == fine.triangles.size());
  REQUIRE(write({glb, check::Refine::never}, shapes::cube(), control).ok());
  CHECK(read(glb).triangles.size() == 12);
}

TEST_CASE("deviation: a gate that passes at limit 0 shows nothing above it, despite rounding") {
  const MapFolder folder;
  Control control;
  for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e6, -1e6, 1e6)}) {
    const Mesh mesh = shapes::moved(shapes::sphere(12), offset);
    const Prepared a(mesh), b(mesh);
    const Outcome outcome = measure(a, b, {}, control);
    REQUIRE(outcome.upper == 0);
    api::ResultFacts facts;
    facts.limit = {{0}};
    facts.direction = api::ResultDirection{0, outcome.a_to_b->bounds.upper, std::nullopt};
    const fs::path path = folder.path() / "map.ply";
    REQUIRE(check::write_deviation({path, check::Refine::always}, a, b, facts, control).ok());
    const auto distances = distances_of(path);
    CHECK(distances.size() > 10'000);
    CHECK(std::all_of(distances.begin(), distances.end(), [](double d) { return d == 0; }));
    facts.direction.reset();  // nothing is certified of this direction
    REQUIRE(check::write_deviation({path, check::Refine::always}, a, b, facts, control).ok());
    const auto free = distances_of(path);
    CHECK(std::any_of(free.begin(), free.end(), [](double d) { return d > 0; }));
  }
}

TEST_CASE("deviation: a failed write is an Error and leaves no partial file") {
  const MapFolder folder;
  Control control;
  const auto nowhere = write({folder.path() / "missing" / "map.ply"}, shapes::cube(), control);
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().message.find("No such file or directory") != std::string::npos);
  fs::create_directory(folder.path() / "taken.ply");
  CHECK_FALSE(write({folder.path() / "taken.ply"}, shapes::cube(), control).ok());
  CHECK_FALSE(write({folder.path() / "huge.glb"}, shapes::cube(1e39), control).ok());
  CHECK(folder.files() == 1);
}

TEST_CASE("deviation: a file named like a temporary one is not touched") {
  const MapFolder folder;
  Control control;
  const fs::path other = folder.path() / "map.ply.part";
  std::ofstream(other) << "another program's";
  REQUIRE(write({folder.path() / "map.ply"}, shapes::cube(), control).ok());
  CHECK(content(other) == "another program's");
  CHECK(folder.files() == 2);
}

TEST_CASE("deviation: a cancelled map writes nothing and is an Error") {
  const MapFolder folder;
  Control control;
  control.cancel();
  const auto stopped = write({folder.path() / "map.ply"}, shapes::cube(), control);
  REQUIRE_FALSE(stopped.ok());
  CHECK(stopped.error().code == ErrorCode::out_of_time);
  CHECK(folder.files() == 0);
}
