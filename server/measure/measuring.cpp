#include "server/measure/measuring.h"

#include <exception>
#include <new>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/options/gate.h"
#include "api/result/response.h"
#include "server/base/heap.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using store::JobState;

// The bounds that a search for the largest distance notes for the areas: those of the search, those of its directions,
// and of the directions before them while a gate is narrowed, or those of the search of the areas.
constexpr std::uint64_t kNotedBytes = 3 * sizeof(float);  // a triangle

double ms_between(LiveJob::Clock::time_point start, LiveJob::Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

bool has_area_stop(const Outcome& outcome, AreaStop stop) {
  if (outcome.sides && outcome.sides->stop == stop) return true;
  if (!outcome.areas) return false;
  const auto& [options, a_to_b, b_to_a] = *outcome.areas;
  return (a_to_b && a_to_b->stop == stop) || (b_to_a && b_to_a->stop == stop);
}

// Stopped by a timeout, a cancel or a limit of this process: a repetition may get further.
bool was_cut_short(const api::Comparison& comparison) {
  const Outcome& outcome = comparison.outcome;
  const Stop stop = outcome.stop;
  if (comparison.options.topology && !(comparison.a.topology && comparison.b.topology)) return true;
  if (stop == Stop::timeout || stop == Stop::cancelled || stop == Stop::budget) return true;
  if (has_area_stop(outcome, AreaStop::timeout) || has_area_stop(outcome, AreaStop::cancelled) ||
      has_area_stop(outcome, AreaStop::budget)) {
    return true;
  }
  return outcome.statistics && outcome.statistics->status != StatisticsStatus::complete;
}

}  // namespace

bool stopped_by_cancel(const Result<api::Comparison>& result) {
  if (!result) return result.error().code == ErrorCode::out_of_time;
  const Outcome& outcome = result->outcome;
  return outcome.stop == Stop::cancelled || has_area_stop(outcome, AreaStop::cancelled) ||
         (outcome.statistics && outcome.statistics->status == StatisticsStatus::cancelled);
}

Problem cancelled_early() {
  return {ProblemKind::cancelled, "the comparison was cancelled before both meshes were read"};
}

// A stored mesh that is compared with itself is read once: the second time it is in the cache.
Result<api::SharedMeshes> load_both(MeshLoader& loader, const MeshSource& a, const MeshSource& b, unsigned threads,
                                    MemoryReservation& memory, Control& control, api::StageTimes& times) {
  using Loaded = std::optional<Result<api::SharedMesh>>;
  std::optional<MemoryReservation> second;
  const auto load_a = [&](bool beside, Control& reading) -> Loaded {
    std::optional<MayFail> may_fail;
    if (beside) {
      may_fail.emplace();
    } else {
      second.reset();
    }
    return loader.load(a, memory, reading);
  };
  // What cannot be read beside, for want of memory or of a process, is read alone; others may have its memory until
  // then.
  const auto load_b = [&](bool beside, Control& reading) -> Loaded {
    second.reset();
    if (!beside) return loader.load(b, memory, reading);
    const MayFail may_fail;
    try {
      auto mesh = loader.load(b, second.emplace(&memory), reading);
      if (mesh || mesh.error().code != ErrorCode::internal) return mesh;
    } catch (const std::bad_alloc&) {
    }
    second.reset();
    return std::nullopt;
  };
  const bool is_same = a.kept && a.kept == b.kept;
  const std::uint64_t smaller = std::min(a.input.bytes.size(), b.input.bytes.size());
  const bool side_by_side = api::reads_side_by_side(threads, smaller) && !is_same && memory.first_attempt();
  auto both = api::read_both(load_a, load_b, side_by_side, control, times);
  if (!both || !second) return both;
  if (auto ok = memory.take_over(*second); !ok) return std::move(ok).error();
  return both;
}

Result<api::Comparison> Measuring::measured(LiveJob& job) const {
  const MayFail may_fail;
  try {
    return measure(job);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::internal, "not enough memory for this comparison; try again later, or with smaller meshes",
                 "", ""};
  } catch (const std::exception& error) {
    log_event("job_failed", job.key.id + ": " + error.what());
    return Error{ErrorCode::internal, "the comparison failed unexpectedly", "", ""};
  }
}

Result<api::Comparison> Measuring::measure(LiveJob& job) const {
  if (job.defect) return *job.defect;
  if (!job.a.holder || !job.b.holder) {
    return Error{ErrorCode::internal,
                 "a mesh of this comparison was removed before it could run; send the comparison again", "", ""};
  }
  const auto start = LiveJob::Clock::now();
  api::ComparisonOptions& options = job.request.options;
  const bool large = !job.request.threads_given && job.bytes >= ThreadBudget::kWorthThreads;
  const ThreadBudget::Loan loan = threads_.lend(large ? static_cast<unsigned>(settings_.workers) : options.threads);
  options.threads = loan.threads();
  metrics_.job_started(ms_between(job.submitted, start) / 1000);
  api::StageTimes times;
  times.queue = ms_between(job.submitted, start);
  return within(memory_, job.control, [&](MemoryReservation& memory) { return measure_within(memory, job, times); });
}

Result<api::Comparison> Measuring::measure_within(MemoryReservation& memory, LiveJob& job,
                                                  api::StageTimes times) const {
  const auto both = load_both(loader_, job.a, job.b, job.request.options.threads, memory, job.control, times);
  if (!both) return both.error();
  const api::SharedMesh &a = both->a, &b = both->b;
  if (job.request.options.align) {  // the moved mesh is another one
    if (auto ok = memory.take_mesh(a->facts.vertices, a->facts.triangles); !ok) return std::move(ok).error();
  }
  if (!job.request.options.regions.empty()) {  // a part of a mesh is another mesh, one at a time
    const auto& larger = a->facts.triangles < b->facts.triangles ? b->facts : a->facts;
    if (auto ok = memory.take_mesh(larger.vertices, larger.triangles); !ok) return std::move(ok).error();
  }
  if (api::engine_options(job.request.options).areas) {
    const std::uint64_t noted = kNotedBytes * (a->facts.triangles + b->facts.triangles);
    if (auto ok = memory.take_more(noted); !ok) return std::move(ok).error();
  }
  memory.keep_meshes();
  auto result = api::compare(a, b, job.request.options, job.control, times);
  if (result) result->id = job.key.id;
  return result;
}

// A job that was cancelled before both meshes were read is cancelled, not failed.
void Measuring::count(LiveJob& job, const Result<api::Comparison>& result) const {
  const Strategy strategy = job.request.options.strategy;
  if (result) return metrics_.job_ended(*result);
  const bool cancelled = stopped_by_cancel(result) && job.control.check() == Interruption::cancelled;
  if (cancelled) return metrics_.job_cancelled_early(strategy);
  metrics_.job_failed(api::to_problem(result.error()).type(), strategy);
}

// A result that does not fit into memory as JSON is a failure.
JobView Measuring::last_view(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const {
  try {
    return concluded(job, result, stopping);
  } catch (const std::exception&) {
    return concluded(job, Error{ErrorCode::internal, "not enough memory for the result", "", ""}, stopping);
  }
}

JobView Measuring::concluded(const LiveJob& job, const Result<api::Comparison>& result, bool stopping) const {
  JobView last = job.view();
  const store::TimePoint finished = clock_.time();
  const auto document = result ? api::document_of(*result) : nlohmann::ordered_json();
  last.row.finished = finished;
  last.row.expires = finished + std::chrono::seconds(settings_.result_ttl_s);
  const bool cancelled = stopped_by_cancel(result) && last.row.cancel_requested;
  if (result) {
    last.row.state = cancelled ? JobState::cancelled : JobState::done;
    const auto& verdict = document.at("verdict");
    last.row.document = document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    last.row.verdict = verdict.is_null() ? "" : verdict.get<std::string>();
    last.reusable = !was_cut_short(*result);
    last.stages = api::stages(*result);
    last.timing = api::to_server_timing(last.stages);
    last.triangles = MeshSizes{result->a.triangles, result->b.triangles};
  } else {
    Problem problem = api::to_problem(result.error());
    if (stopping && stopped_by_cancel(result)) problem.kind = ProblemKind::shutting_down;
    if (cancelled) problem = cancelled_early();
    last.row.state = cancelled ? JobState::cancelled : JobState::failed;
    last.row.problem = to_json(problem);
  }
  return last;
}

}  // namespace meshgauge::server
