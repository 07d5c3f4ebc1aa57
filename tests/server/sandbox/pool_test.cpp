#include "server/sandbox/pool.h"

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "server/sandbox/sandbox.h"

using namespace meshgauge;
using namespace meshgauge::server;
using namespace meshgauge::server::sandbox;

namespace {

using std::chrono::milliseconds;

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

void check_same(const Result<api::LoadedMesh>& here, const Result<api::LoadedMesh>& there) {
  REQUIRE(here.ok() == there.ok());
  if (!here) {
    CHECK(here.error().code == there.error().code);
    CHECK(here.error().message == there.error().message);
    CHECK(here.error().part == there.error().part);
    CHECK(here.error().where == there.error().where);
    return;
  }
  CHECK(same_bytes(here->mesh.positions, there->mesh.positions));
  CHECK(same_bytes(here->mesh.triangles, there->mesh.triangles));
  CHECK(here->format == there->format);
  CHECK(here->notes.gzip == there->notes.gzip);
  CHECK(here->notes.polygons == there->notes.polygons);
  CHECK(here->notes.skipped_primitives == there->notes.skipped_primitives);
  CHECK(here->notes.cloud == there->notes.cloud);
  CHECK(here->notes.welded_vertices == there->notes.welded_vertices);
  CHECK(here->notes.unused_objects == there->notes.unused_objects);
  CHECK(here->notes.unit == there->notes.unit);
  CHECK(here->notes.filename_says == there->notes.filename_says);
  CHECK(here->notes.media_type_says == there->notes.media_type_says);
  CHECK(here->groups == there->groups);
  CHECK(here->sha256 == there->sha256);
}

}  // namespace

TEST_CASE("pool: a mesh equals the one read in this process") {
  Sandbox sandbox;
  sandbox.start();
  const std::string_view files[] = {
      kTriangle,
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nl 1 2\nf 1 2 3 4\n",
      "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n",
      "solid x\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid x\n",
      "v 0 0 0\nv 1 0 0\n",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\ng a b\nf 1 2 3\ng b\nf 1 2 3\n",
  };
  for (const std::string_view file : files) {
    const auto here = api::load({"a", std::as_bytes(std::span(file)), "a.obj", ""}, {});
    REQUIRE(here.ok());
    check_same(here, sandbox.read(file));
  }
  CHECK(sandbox.pool.counters()[End::read] == std::size(files));
  CHECK(sandbox.logged().empty());
}

TEST_CASE("pool: a reader's Error equals the one of this process") {
  Sandbox sandbox;
  sandbox.start();
  for (const std::string_view file :
       {"v 0 0 0\nv 1 0 nan\nf 1 2 3\n", "v 0 0 0\nf 1 2 3\n", "", "?", "v 0 0 0\nl 1 1\n"}) {
    const auto here = api::load({"a", std::as_bytes(std::span(file)), "a.obj", ""}, {});
    REQUIRE(!here.ok());
    check_same(here, sandbox.read(file));
  }
  CHECK(sandbox.pool.counters()[End::read] == 5);
}

// With no corpus at hand there is nothing to see: MESHGAUGE_CORPUS.
TEST_CASE("pool: every file of the corpus gives the same result as in this process") {
  const char* const corpus = std::getenv("MESHGAUGE_CORPUS");
  if (corpus == nullptr || *corpus == '\0') return;
  Sandbox sandbox;
  sandbox.start();
  std::uint64_t files = 0;
  for (const char* const folder : {"formats", "malformed"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(std::filesystem::path(corpus) / folder)) {
      if (!entry.is_regular_file()) continue;
      CAPTURE(entry.path());
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      const api::MeshInput input{"a", std::as_bytes(std::span(text)), entry.path().filename(), ""};
      Control control;
      check_same(api::load(input, {}), sandbox.pool.load(input, {}, control));
      ++files;
    }
  }
  CHECK(files > 0);
  CHECK(sandbox.pool.counters()[End::read] == files);
}

TEST_CASE("pool: limits and hints reach the reader") {
  Sandbox sandbox;
  sandbox.start();
  Control control;
  check_refused(sandbox.read(kTriangle, control, {2, 10, 1000}), ErrorCode::too_large);
  const std::string_view unnamed = "# an OBJ by its name alone\n";
  CHECK(sandbox.read(unnamed).error().code == ErrorCode::empty_mesh);
}

TEST_CASE("pool: a file is read by its descriptor") {
  Sandbox sandbox;
  sandbox.start();
  const Descriptor file = sealed_copy(std::as_bytes(std::span(kTriangle)));
  Control control;
  const std::string_view same = kTriangle;
  const auto mesh = sandbox.pool.load({"a", std::as_bytes(std::span(same)), "", "", file.get()}, {}, control);
  REQUIRE(mesh.ok());
  CHECK(mesh->mesh.positions[1] == Vec3(1, 0, 0));
}

TEST_CASE("pool: a file that was cut off is not its sender's fault") {
  Sandbox sandbox;
  sandbox.start();
  const std::string whole = std::string(kTriangle) + std::string(100'000, '#') + "\n";
  for (const std::size_t left : {std::size_t{0}, std::size_t{5000}, std::size_t{8192}}) {
    const Descriptor file = sealed_copy(std::as_bytes(std::span(whole).first(left)));
    Control control;
    const auto mesh = sandbox.pool.load({"a", std::as_bytes(std::span(whole)), "a.obj", "", file.get()}, {}, control);
    REQUIRE_FALSE(mesh.ok());
    CHECK(mesh.error().code == ErrorCode::internal);
    CHECK(mesh.error().message.find("the stored bytes of 'a' are damaged") != std::string::npos);
  }
}

TEST_CASE("pool: a mesh outlives the pool that read it") {
  Result<api::LoadedMesh> mesh = Error{};
  {
    Sandbox sandbox;
    sandbox.start();
    mesh = sandbox.read(kTriangle);
  }
  REQUIRE(mesh.ok());
  CHECK(mesh->mesh.positions[1] == Vec3(1, 0, 0));
}

TEST_CASE("pool: as many files are read at a time as it has parsers") {
  Sandbox sandbox({hostile_program()}, 1);
  sandbox.start();
  Endless endless(sandbox);
  REQUIRE(eventually([] { return !running().empty(); }));
  Control late(Control::Clock::now() + milliseconds(50));
  CHECK(sandbox.read(kTriangle, late).error().code == ErrorCode::out_of_time);
  auto waiting = std::async(std::launch::async, [&] { return sandbox.works(); });
  endless.control().cancel();
  CHECK(!endless.result().ok());
  CHECK(waiting.get());
}

TEST_CASE("pool: a reading that may not wait for a turn ends at once") {
  struct Hurried final : Memory {
    Result<Done> wait_for_turn() override { return Error{ErrorCode::internal, "does not wait", "", ""}; }
    Result<std::uint64_t> take_reader(std::uint64_t bytes) override { return bytes; }
    void end_reader() override { ++ends; }
    Result<Done> take_mesh(std::uint64_t, std::uint64_t) override { return Done{}; }
    int ends = 0;
  } memory;
  Sandbox sandbox({hostile_program()}, 1);
  sandbox.start();
  Control control;
  CHECK(sandbox.read(kTriangle, control, {}, &memory).ok());
  Endless endless(sandbox);
  REQUIRE(eventually([] { return !running().empty(); }));
  CHECK(sandbox.read(kTriangle, control, {}, &memory).error().message == "does not wait");
  CHECK(memory.ends == 1);
  endless.control().cancel();
  CHECK(!endless.result().ok());
  CHECK(sandbox.read(kTriangle, control, {}, &memory).ok());  // it has left its turn to others
}

TEST_CASE("pool: a program that is no spawner is an Error") {
  for (const std::string program : {"/nonexistent", "/bin/true"}) {
    Sandbox sandbox({program});
    const auto lacks = sandbox.pool.start();
    REQUIRE(!lacks.ok());
    CHECK(lacks.error().message.starts_with("the process that reads uploads could not be started: "));
  }
  Sandbox unlimited({beside_this_program("without"), "limits", hostile_program()});
  CHECK(unlimited.pool.start().error().message ==
        "the process that reads uploads could not be started: the limits of a process cannot be set");
  Sandbox childless({hostile_program(), "forks", "0"});
  CHECK(
      childless.pool.start().error().message ==
      "the process that reads uploads could not be started: no process can be made: Resource temporarily unavailable");
}
