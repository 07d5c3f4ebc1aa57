#include "python/native.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <span>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/base/machine.h"
#include "api/base/problem.h"
#include "api/compare/compare.h"
#include "api/compare/mesh_file.h"
#include "api/map/deviation_maker.h"
#include "api/options/request.h"
#include "api/result/response.h"
#include "api/result/result_document.h"
#include "cli/commands.h"
#include "cli/run.h"
#include "engine/hausdorff.h"

using namespace meshgauge;

namespace {

constexpr std::chrono::hours kLongestTimeout{24 * 7};  // also what a job without a timeout has

static_assert(sizeof(Vec3) == 3 * sizeof(double) && alignof(Vec3) == alignof(double));
static_assert(sizeof(Triangle) == 3 * sizeof(std::uint32_t));

// A copy, which is checked and measured: another thread may change the caller's arrays meanwhile, and an index that was
// checked would lead elsewhere. The search takes several times the memory and the time of the copy.
std::shared_ptr<const Mesh> copy_of(const meshgauge_mesh& mesh) {
  const std::span positions(reinterpret_cast<const Vec3*>(mesh.positions), mesh.vertices);
  const std::span triangles(reinterpret_cast<const Triangle*>(mesh.triangles), mesh.triangle_count);
  const bool is_cloud = triangles.empty() && !positions.empty();
  Mesh copy;
  copy.positions.assign(positions.begin(), positions.end());
  copy.triangles.assign(triangles.begin(), triangles.end());
  if (is_cloud) copy.triangles = points_as_triangles(positions.size());
  return std::make_shared<const Mesh>(std::move(copy));
}

Result<api::SharedMesh> prepared_arrays(const meshgauge_mesh& mesh, const std::string& part, Control& control) {
  const std::shared_ptr<const Mesh> copy = copy_of(mesh);
  const MeshView view = *copy;
  api::ReadNotes notes;
  notes.cloud = mesh.triangle_count == 0 && mesh.vertices > 0;
  const auto interrupted = [&control] { return control.check() != Interruption::none; };
  if (auto ok = validate(view, MeshLimits{}, part, interrupted); !ok) return ok.error();
  const std::size_t bytes = view.positions.size_bytes() + view.triangles.size_bytes();
  auto prepared = std::make_shared<const api::PreparedMesh>(api::LoadedMesh{view, api::Format::arrays, notes, "", copy},
                                                            bytes, Prepared::Use::once, interrupted);
  if (auto ok = api::in_time(control, "'" + part + "' was read"); !ok) return ok.error();
  return prepared;
}

Result<api::SharedMesh> prepared(const api::MeshInput& input, Control& control) {
  return api::prepare(api::load(input, api::ReadLimits{}), input, Prepared::Use::once, control);
}

// Reads and prepares one mesh. `part`: its name in messages, unless it has a path.
Result<api::SharedMesh> read(const meshgauge_mesh& mesh, const std::string& part, Control& control) {
  if (auto ok = api::in_time(control, "'" + part + "' was read"); !ok) return ok.error();
  if (mesh.path) {
    const auto file = api::MeshFile::open(mesh.path);
    if (!file) return file.error();
    return prepared({mesh.path, file->bytes(), mesh.path, ""}, control);
  }
  if (mesh.bytes)
    return prepared({part, {static_cast<const std::byte*>(mesh.bytes), mesh.byte_count}, "", ""}, control);
  return prepared_arrays(mesh, part, control);
}

api::MeshReader reader(const meshgauge_mesh& mesh, const std::string& part) {
  return api::reader_here([&mesh, part](Control& control) { return read(mesh, part, control); });
}

struct AtVertices {
  std::vector<double> distances;
  std::vector<double> with_signs;  // empty: without
};

Result<Done> measure_vertices(const api::SharedMeshes& meshes, const api::Comparison& comparison, Control& control,
                              AtVertices& found) {
  const auto facts = api::result_facts(api::document_of(comparison), api::Side::a);
  if (!facts) return facts.error();
  const auto pair = api::in_unit_of_result(meshes.a, meshes.b, facts->units, facts->motion, control);
  if (!pair) return pair.error();
  api::MapOptions options;
  options.threads = comparison.options.threads;
  const auto made = api::make_deviation(*pair->a, *pair->b, *facts, options, control);
  if (!made) return made.error();
  const api::DeviationMap& map = made->map();
  found.distances.assign(map.distances.begin(), map.distances.end());
  for (std::size_t v = 0; v < map.sides.size(); ++v) found.with_signs.push_back(map.signed_distance(v));
  return Done{};
}

Result<api::Comparison> compared(const meshgauge_mesh& a, const meshgauge_mesh& b, const std::string& options,
                                 Control& control, AtVertices* at_vertices) {
  auto request = api::parse_options(options, {kLongestTimeout, kLongestTimeout}, api::kPython);
  if (!request) return request.error();
  if (!request->threads_given) {
    const auto most = static_cast<unsigned>(api::kThreadsRange.high);
    request->options.threads = std::min(api::processors(), most);
  }
  control.set_deadline(Control::Clock::now() + request->timeout);
  api::StageTimes times;
  const bool is_same = a.path && b.path && std::strcmp(a.path, b.path) == 0;
  const bool side_by_side = api::reads_side_by_side(request->options.threads);
  const auto meshes = api::read_both(reader(a, "a"), is_same ? nullptr : reader(b, "b"), side_by_side, control, times);
  if (!meshes) return meshes.error();
  auto comparison = api::compare(meshes->a, meshes->b, request->options, control, times);
  if (!comparison || !at_vertices) return comparison;
  control.set_deadline(Control::Clock::now() + request->timeout);
  const auto ok = measure_vertices(*meshes, *comparison, control, *at_vertices);
  return ok ? std::move(comparison) : ok.error();
}

}  // namespace

struct meshgauge_job {
  meshgauge_mesh a{};
  meshgauge_mesh b{};
  std::string options;
  bool wants_vertices = false;
  AtVertices at_vertices;
  Control control;
  std::thread thread;
  std::mutex mutex;  // guards `ended`
  std::condition_variable changed;
  bool ended = false;
  bool measured = false;  // true: `answer` is a result, else a problem
  std::string answer;

  void run() {
    measure_meshes();
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  }

 private:
  void measure_meshes() try {
    const auto comparison = compared(a, b, options, control, wants_vertices ? &at_vertices : nullptr);
    measured = comparison.ok();
    answer = measured ? api::to_json(*comparison) : api::to_json(api::to_problem(comparison.error()));
  } catch (const std::exception&) {
    measured = false;
    answer.clear();
  }
};

int meshgauge_main(int argc, char** argv) { return cli::run(argc, argv, cli::add_measuring); }

const char* meshgauge_version() { return version(); }

meshgauge_job* meshgauge_create() { return new (std::nothrow) meshgauge_job; }

int meshgauge_start(meshgauge_job* job, const meshgauge_mesh* a, const meshgauge_mesh* b, const char* options,
                    int at_vertices) try {
  job->a = *a;
  job->b = *b;
  job->options = options;
  job->wants_vertices = at_vertices != 0;
  job->thread = std::thread([job] { job->run(); });
  return 1;
} catch (const std::exception&) {
  return 0;
}

int meshgauge_wait(meshgauge_job* job, int milliseconds) {
  std::unique_lock lock(job->mutex);
  return job->changed.wait_for(lock, std::chrono::milliseconds(milliseconds), [job] { return job->ended; }) ? 1 : 0;
}

const char* meshgauge_answer(const meshgauge_job* job, const char** problem) {
  *problem = job->measured ? nullptr : job->answer.c_str();
  return job->measured ? job->answer.c_str() : nullptr;
}

size_t meshgauge_at_vertices(const meshgauge_job* job, const double** distances, const double** with_signs) {
  const auto& [all, signs] = job->at_vertices;
  *distances = all.data();
  *with_signs = signs.empty() ? nullptr : signs.data();
  return all.size();
}

void meshgauge_stop(meshgauge_job* job) {
  job->control.cancel();
  if (job->thread.joinable()) job->thread.join();
}

void meshgauge_free(meshgauge_job* job) {
  meshgauge_stop(job);
  delete job;
}
