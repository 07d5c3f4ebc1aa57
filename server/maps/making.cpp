#include "server/maps/making.h"

#include <algorithm>
#include <exception>
#include <new>
#include <utility>

#include "api/base/problem.h"
#include "api/compare/compare.h"
#include "api/map/deviation_glb.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

class Watch {
 public:
  double lap_ms() {
    const auto now = Making::Clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(start_, now)).count();
  }

 private:
  Making::Clock::time_point start_ = Making::Clock::now();
};

// A GLB is in memory twice before it is written.
Result<Done> check_size(const MapOrder& order, const Prepared& shown, std::uint64_t max_bytes) {
  if (order.query.kind != MapKind::glb) return Done{};
  const std::size_t triangles = shown.mesh().triangles.size();
  const std::size_t most = std::min(triangles, order.query.max_triangles.value_or(triangles));
  const std::uint64_t bytes = 2 * api::glb_bytes(std::min(shown.mesh().positions.size(), 3 * most), most,
                                                 order.facts.sides, order.query.normals);
  if (bytes <= max_bytes) return Done{};
  return Error{ErrorCode::too_large,
               "a GLB of " + std::to_string(most) + " triangles takes " + std::to_string(bytes) +
                   " bytes to make, more than the limit of " + std::to_string(max_bytes) +
                   "; ask for fewer by max_triangles, or for the .ply",
               "", ""};
}

// The comparison has read the bytes before, so an error now is internal: another version, or a lost process.
Error as_ours(Error error) {
  const int status = api::to_problem(error).status();
  if (status == 415 || status == 422) error.code = ErrorCode::internal;
  return error;
}

Result<MadeFile> made(Making& making, const MapTools& tools, MemoryReservation& memory) {
  const MapOrder& order = making.order;
  Control& control = making.control;
  MadeFile result;
  Watch watch;
  const double queue_ms = std::chrono::duration<double, std::milli>(Making::Clock::now() - making.submitted).count();
  if (auto ok = api::in_time(control, "'a' was read"); !ok) return ok.error();
  const auto loan = tools.threads.lend(
      order.bytes >= ThreadBudget::kWorthThreads ? static_cast<unsigned>(tools.settings.workers) : 1);
  api::StageTimes times;
  const auto both = load_both(tools.loader, order.a, order.b, loan.threads(), memory, control, times);
  if (!both) return as_ours(both.error());
  if (order.facts.motion) {  // the moved mesh is another one
    if (auto ok = memory.take_mesh(both->a->facts.vertices, both->a->facts.triangles); !ok) return as_ours(ok.error());
  }
  memory.keep_meshes();
  const double read_ms = watch.lap_ms();

  const bool of_a = order.query.of == api::Side::a;
  const auto measured = api::in_unit_of_result(both->a, both->b, order.facts.units, order.facts.motion, control);
  if (!measured) return measured.error();
  const Prepared& shown = of_a ? *measured->a : *measured->b;
  const Prepared& other = of_a ? *measured->b : *measured->a;
  if (auto ok = check_size(order, shown, tools.settings.max_heap_bytes); !ok) return ok.error();
  api::MapOptions options;
  options.refine = is_for_viewing(order.query.kind);
  options.max_triangles = order.query.max_triangles.value_or(options.max_triangles);
  options.normals = order.query.normals;
  options.threads = loan.threads();
  options.simd = tools.settings.simd;
  const auto map = api::make_deviation(shown, other, order.facts, options, control);
  if (!map) return map.error();
  const double measure_ms = watch.lap_ms();

  auto file = tools.cache.keep(
      *order.coming, [&](std::ostream& out) { return api::write_deviation(map->map(), order.query.kind, out); });
  if (!file) return file.error();
  result.file = std::move(*file);
  const double write_ms = watch.lap_ms();
  result.stages = {{"queue", queue_ms}, {"read", read_ms}, {"measure", measure_ms}, {"write", write_ms}};
  result.stages.push_back({"total", queue_ms + read_ms + measure_ms + write_ms});
  return result;
}

}  // namespace

Making::Making(MapOrder what) : order(std::move(what)) { control.set_deadline(submitted + order.timeout); }

void Making::end(Result<MadeFile> result) {
  std::vector<std::function<void()>> wakes;
  {
    const std::lock_guard lock(mutex_);
    result_.emplace(std::move(result));
    wakes.swap(wakes_);
  }
  for (const auto& wake : wakes) wake();
}

const Result<MadeFile>* Making::result() const {
  const std::lock_guard lock(mutex_);
  return result_ ? &*result_ : nullptr;
}

void Making::on_end(std::function<void()> wake) {
  {
    const std::lock_guard lock(mutex_);
    if (!result_) return wakes_.push_back(std::move(wake));
  }
  wake();
}

Result<MadeFile> make_map(Making& making, const MapTools& tools) {
  making.begun = true;
  try {
    return within(tools.memory, making.control, [&](MemoryReservation& memory) { return made(making, tools, memory); });
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::internal, "not enough memory for this deviation map", "", ""};
  } catch (const std::exception& error) {
    log_event("job_failed", "deviation map of " + making.order.key.job.id + ": " + error.what());
    return Error{ErrorCode::internal, "the deviation map failed unexpectedly", "", ""};
  }
}

}  // namespace meshgauge::server
