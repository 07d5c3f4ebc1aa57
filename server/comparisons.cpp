#include "server/comparisons.h"

#include <algorithm>
#include <exception>
#include <future>

#include "api/response.h"
#include "server/multipart.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr milliseconds kTick{20};  // how soon a client that went away is noticed

double ms_between(Clock::time_point start, Clock::time_point end) {
  return std::chrono::duration<double, std::milli>(end - start).count();
}

api::RequestLimits request_limits(const Settings& settings) {
  return {milliseconds(settings.default_timeout_ms), milliseconds(settings.max_timeout_ms)};
}

api::ReadLimits read_limits(const Settings& settings) {
  return {settings.max_vertices, settings.max_triangles, settings.max_expanded_bytes};
}

api::MeshInput input_of(const std::string& part, const MeshPart& mesh) {
  return {part, mesh.upload->bytes(), mesh.head.filename, mesh.head.content_type, mesh.upload->file()};
}

}  // namespace

// Shared: the worker may still hold it when the connection's thread has its answer.
struct Comparisons::Job {
  Form form;
  api::Request request;
  std::string id;
  Clock::time_point submitted;
  Control control;
  std::promise<Result<api::Comparison>> result;
};

Comparisons::Comparisons(const Settings& settings, Compare compare, Metrics& metrics)
    : settings_(settings),
      compare_(std::move(compare)),
      metrics_(metrics),
      budget_(settings.max_upload_bytes),
      threads_(settings.workers),
      jobs_(settings.workers, settings.queue) {
  watch_levels();
}

void Comparisons::watch_levels() {
  const auto fixed = [](std::uint64_t n) { return [n] { return static_cast<double>(n); }; };
  metrics_.watch(Level::queue_depth, [this] { return static_cast<double>(jobs_.load().waiting); });
  metrics_.watch(Level::jobs_running, [this] { return static_cast<double>(jobs_.load().running); });
  metrics_.watch(Level::upload_bytes, [this] { return static_cast<double>(budget_.used()); });
  metrics_.watch(Level::queue_limit, fixed(settings_.queue));
  metrics_.watch(Level::workers, fixed(settings_.workers));
  metrics_.watch(Level::upload_limit_bytes, fixed(settings_.max_upload_bytes));
}

void Comparisons::create(Exchange& exchange) {
  if (draining_.load()) return answer(exchange, {ProblemKind::shutting_down, "no new work is taken", {}});
  auto slot = jobs_.admit();
  if (!slot) {
    return answer(exchange, {ProblemKind::overloaded, "all workers are busy and the queue is full; try again", {}});
  }
  Form form;
  if (auto refusal = receive(exchange, form)) return answer(exchange, *refusal);
  auto request = api::parse_options(form.options, request_limits(settings_));
  if (!request) return answer(exchange, api::to_problem(request.error()));
  const auto job = start(std::move(*slot), std::move(form), std::move(*request), exchange.id);
  auto result = job->result.get_future();
  while (result.wait_for(kTick) != std::future_status::ready) {
    if (exchange.connection.peer_gone()) job->control.cancel();
  }
  respond(exchange, result.get());
}

std::optional<Problem> Comparisons::receive(Exchange& exchange, Form& form) {
  if (!exchange.head.query.empty()) {
    return Problem{ProblemKind::malformed_request, "this path takes no query parameters", {}};
  }
  std::string boundary;
  if (auto refusal = find_boundary(exchange.head.header("content-type"), boundary)) return refusal;
  FormReceiver receiver(form, settings_, budget_);
  MultipartParser parser(boundary, receiver);
  if (auto refusal = exchange.body.read([&](std::string_view piece) { return parser.feed(piece); })) return refusal;
  if (auto refusal = parser.finish()) return refusal;
  return receiver.check_complete();
}

std::shared_ptr<Comparisons::Job> Comparisons::start(JobQueue::Slot slot, Form form, api::Request request,
                                                     const std::string& id) {
  const auto job = std::make_shared<Job>();
  job->form = std::move(form);
  job->request = std::move(request);
  std::size_t& memory_bytes = job->request.options.max_memory_bytes;
  memory_bytes = std::min<std::size_t>(memory_bytes, settings_.max_heap_bytes);
  job->request.options.simd = settings_.simd;
  job->id = id;
  job->submitted = Clock::now();
  job->control.set_deadline(job->submitted + job->request.timeout);
  jobs_.submit(std::move(slot), {std::shared_ptr<Control>(job, &job->control),
                                 [this, job](JobQueue::Slot held) { run(*job, std::move(held)); }});
  return job;
}

// The job's edge: whatever is thrown ends here.
void Comparisons::run(Job& job, JobQueue::Slot slot) {
  try {
    auto result = measure(job);
    { const JobQueue::Slot done = std::move(slot); }
    job.result.set_value(std::move(result));
  } catch (...) {
    metrics_.job_failed(Problem{}.type(), job.request.options.strategy);
    { const JobQueue::Slot done = std::move(slot); }
    job.result.set_exception(std::current_exception());
  }
}

Result<api::Comparison> Comparisons::measure(Job& job) {
  const double waited_ms = ms_between(job.submitted, Clock::now());
  metrics_.job_started(waited_ms / 1000);
  Options& options = job.request.options;
  const ThreadBudget::Loan loan = threads_.lend(options.threads);
  options.threads = loan.threads();
  auto result =
      compare_(input_of("a", job.form.a), input_of("b", job.form.b), options, read_limits(settings_), job.control);
  if (result) {
    result->id = job.id;
    result->units = job.request.units;
    result->times.queue = waited_ms;
    result->times.total += waited_ms;
    metrics_.job_ended(*result);
  } else {
    metrics_.job_failed(api::to_problem(result.error()).type(), options.strategy);
  }
  return result;
}

void Comparisons::respond(Exchange& exchange, const Result<api::Comparison>& result) const {
  if (!result) {
    const bool ended = draining_.load() && result.error().code == ErrorCode::out_of_time;
    return answer(exchange, ended ? Problem{ProblemKind::shutting_down, result.error().message, {}}
                                  : api::to_problem(result.error()));
  }
  note(exchange, *result);
  exchange.response = {200, "application/json", to_json(*result), {{"Server-Timing", to_server_timing(*result)}}};
}

}  // namespace meshgauge::server
