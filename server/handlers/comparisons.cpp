#include "server/handlers/comparisons.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/problem.h"
#include "server/access/entrance.h"
#include "server/handlers/job_document.h"
#include "server/handlers/refusals.h"
#include "server/http/comparison_body.h"
#include "server/http/head_values.h"

namespace meshgauge::server {
namespace {

using api::not_found;
using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr milliseconds kWaitTick{100};     // between two looks at a job whose end may not be signalled
constexpr milliseconds kProgressGap{100};  // between two events of a stream
constexpr milliseconds kQuiet{10'000};     // to the next look at a job that does not change

// Without a preference the client waits for the result.
Jobs::Kind kind_of(const Preferences& preferences) {
  return preferences.wait ? Jobs::Kind::durable : Jobs::Kind::awaited;
}

store::JobKey job_key_of(const Exchange& exchange) { return {exchange.owner, exchange.segment}; }

// A document without the ids of stored meshes is often meant for files.
Error with_remedy(Error error) {
  if (error.where == "/a" || error.where == "/b") {
    error.message +=
        "; a JSON body names stored meshes: files are sent as multipart/form-data (curl -F a=@part.stl -F "
        "b=@baseline.stl)";
  }
  return error;
}

// Answers for a comparison that ended without a result. The worker stores its problem as JSON text; a job that was
// cancelled in the queue, or that the store gave up, has none.
void answer_stored(Exchange& exchange, const store::Job& row, milliseconds retry_after) {
  if (row.problem.empty() && row.state == store::JobState::cancelled) {
    return answer(exchange, cancelled_early());
  }
  if (row.problem.empty()) return answer(exchange, Problem{ProblemKind::internal, "given up: " + row.last_error});
  const auto json = nlohmann::json::parse(row.problem, nullptr, false);
  if (!json.is_object()) return answer(exchange, Problem{ProblemKind::internal, "the comparison failed"});
  answer(exchange, {json.value("status", 500), json.value("type", ""), row.problem}, retry_after);
}

}  // namespace

// A POST, as far as it is parsed.
struct Comparisons::Post {
  Post(const Settings& settings, const UploadShare& share) : body(settings, share) {}

  Terms terms;
  bool repeats = false;  // a comparison with its Idempotency-Key is stored
  Submission submission;
  std::optional<Scheduler::Slot> slot = std::nullopt;  // null: it repeats
  ComparisonBody body;
};

// A client that waits for a job.
struct Comparisons::Waiting {
  std::shared_ptr<LiveJob> job;
  Terms terms;
  std::optional<Clock::time_point> until;
  std::shared_ptr<const void> place;
  std::shared_ptr<const void> listening;
};

Comparisons::Comparisons(const Settings& settings, Jobs& jobs, const Stores& stores, Access& access,
                         ByteBudget& uploads)
    : settings_(settings),
      jobs_(jobs),
      stores_(stores),
      access_(access),
      uploads_(uploads),
      watchers_(ConnectionLimit::shared(settings.max_event_streams)) {}

void Comparisons::refuse(Exchange& exchange) const {
  if (draining_.load()) return answer(exchange, shutting_down());
  // One that repeats an Idempotency-Key needs no place.
  if (!exchange.idempotency_key.value.empty()) return;
  const Jobs::Kind kind = kind_of(exchange.preferences);
  if (jobs_.has_place(kind, client_of(exchange))) return;
  answer(exchange, queue_full(), jobs_.expected_wait(kind));
}

void Comparisons::create(Exchange& exchange) {
  if (draining_.load()) return answer(exchange, shutting_down());
  if (const auto& refusal = exchange.idempotency_key.problem) return answer(exchange, *refusal);
  const auto post = std::make_shared<Post>(settings_, UploadShare(uploads_, client_of(exchange)));
  Submission& submission = post->submission;
  submission.key = {exchange.owner, exchange.id};
  submission.client = client_of(exchange);
  submission.idempotency_key = exchange.idempotency_key.value;
  submission.durable = post->terms.durable = exchange.preferences.wait || !submission.idempotency_key.empty();
  if (const auto there = jobs_.available(); !there) return answer(exchange, api::to_problem(there.error()));
  const auto repeats = jobs_.repeats(submission);
  if (!repeats) return answer(exchange, api::to_problem(repeats.error()));
  *repeats ? repeat(exchange, post) : admit(exchange, post);
}

// The comparison that took the last place may be this request, sent before and stored meanwhile. false: it is not.
bool Comparisons::repeat_if_known(Exchange& exchange, const std::shared_ptr<Post>& post) {
  const auto repeats = jobs_.repeats(post->submission);
  if (!repeats || !*repeats) return false;
  repeat(exchange, post);
  return true;
}

void Comparisons::admit(Exchange& exchange, const std::shared_ptr<Post>& post) {
  const Jobs::Kind kind = kind_of(exchange.preferences);
  auto slot = jobs_.admit(kind, post->submission.client);
  if (!slot) {
    if (repeat_if_known(exchange, post)) return;
    return answer(exchange, queue_full(), jobs_.expected_wait(kind));
  }
  auto counted = access_.take_job(exchange.owner);
  if (const auto* denial = std::get_if<Denial>(&counted)) {
    slot.reset();
    if (!repeat_if_known(exchange, post)) answer(exchange, *denial);
    return;
  }
  post->slot.emplace(std::move(*slot));
  post->submission.counted.emplace(std::get<JobSlot>(std::move(counted)));
  post->submission.trace = traceparent(exchange.trace);
  receive(exchange, post);
}

// A comparison that was accepted before needs no place in the queue, no storage and no stored meshes, and is not
// refused for lack of them.
void Comparisons::repeat(Exchange& exchange, const std::shared_ptr<Post>& post) {
  post->repeats = true;
  receive(exchange, post);
}

void Comparisons::submit(Exchange& exchange, Post& post) {
  if (post.repeats) return follow(exchange, jobs_.repeated(post.submission), post);
  follow(exchange, jobs_.submit(std::move(*post.slot), std::move(post.submission)), post);
}

void Comparisons::follow(Exchange& exchange, const Jobs::Submitted& submitted, const Post& post) {
  if (const auto* denial = std::get_if<Denial>(&submitted)) return answer(exchange, *denial);
  if (const auto* job = std::get_if<std::shared_ptr<LiveJob>>(&submitted)) return wait(exchange, *job, post);
  respond(exchange, std::get<JobView>(submitted), post.terms);
}

void Comparisons::receive(Exchange& exchange, const std::shared_ptr<Post>& post) {
  const std::shared_ptr<ComparisonBody> body(post, &post->body);
  ComparisonBody::receive(body, exchange, [this, &exchange, post](const Refusal& lost) {
    if (lost) return refuse_body(exchange, *lost);
    if (const auto refusal = parse(exchange, *post)) return answer(exchange, *refusal);
    submit(exchange, *post);
  });
}

// The bytes of all uploads become free as the queue does.
void Comparisons::refuse_body(Exchange& exchange, const Problem& problem) const {
  const bool full = problem.kind == ProblemKind::overloaded;
  answer(exchange, problem, full ? jobs_.expected_wait(kind_of(exchange.preferences)) : std::chrono::seconds(1));
}

Comparisons::Refusal Comparisons::parse(Exchange& exchange, Post& post) {
  if (post.body.is_form()) {
    take_form(post);
  } else if (auto refusal = parse_ids(exchange.owner, post)) {
    return refusal;
  }
  auto request = api::parse_options(post.submission.options, request_limits(settings_));
  if (!request) return api::to_problem(request.error());
  post.submission.request = *request;
  return std::nullopt;
}

void Comparisons::take_form(Post& post) {
  Form& form = post.body.form();
  post.submission.options = std::move(form.options);
  post.submission.a = source_of("a", std::move(form.a));
  post.submission.b = source_of("b", std::move(form.b));
}

Comparisons::Refusal Comparisons::parse_ids(const std::string& owner, Post& post) {
  auto pair = api::parse_stored_pair(post.body.text());
  if (!pair) return api::to_problem(with_remedy(pair.error()));
  post.submission.options = std::move(pair->options);
  post.submission.a.id = std::move(pair->a);
  post.submission.b.id = std::move(pair->b);
  if (post.repeats) return std::nullopt;
  if (auto missing = open_mesh(owner, "a", post.submission.a)) return missing;
  return open_mesh(owner, "b", post.submission.b);
}

std::optional<Problem> Comparisons::open_mesh(const std::string& owner, const std::string& part, MeshSource& source) {
  const std::string id = source.id;
  const store::BlobKey key{owner, id};
  const auto row = stores_.meshes.get_mesh(key);
  if (!row) return api::to_problem(row.error());
  auto blob = *row ? stores_.blobs.open(key) : Result<std::optional<store::Blob>>(std::optional<store::Blob>());
  if (!blob) return api::to_problem(blob.error());
  if (!*blob) {
    const std::string what = "the mesh '" + part + "' is not stored; send it by PUT /v1/meshes/" + id;
    return Problem{ProblemKind::unknown_mesh, what, {{part, "/" + part, what}}};
  }
  const auto now = stores_.jobs.time();
  stores_.meshes.touch_mesh(key, now, now + std::chrono::seconds(settings_.mesh_ttl_s));
  source = source_of(part, std::move(**blob), id);
  source.input.filename = (*row)->file_name;
  source.input.media_type = (*row)->media_type;
  source.kept = MeshCache::key(owner, id, source.input.filename, source.input.media_type);
  return std::nullopt;
}

void Comparisons::wait(Exchange& exchange, const std::shared_ptr<LiveJob>& job, const Post& post) {
  const Terms& terms = post.terms;
  const auto& most = exchange.preferences.wait;
  // A client that does not want to wait needs no place, and gets a 202 even if the job has already ended.
  if (most == milliseconds(0)) return accept(exchange, job->view(), terms);
  auto waiting = std::make_shared<Waiting>();
  waiting->job = job;
  waiting->terms = terms;
  const bool repeated =
      job->key.id != exchange.id;  // an earlier request with this Idempotency-Key holds the queue place
  if (most || repeated) waiting->place = watchers_.take(client_of(exchange));
  if (most) waiting->until = waiting->place ? terms.since + *most : Clock::now();
  if (repeated && !most && !waiting->place) return answer(exchange, too_many_watchers(settings_));
  waiting->listening = job->on_end(exchange.wake);
  exchange.response.quick = true;
  exchange.response.later = [this, waiting](Exchange& later) { return look(later, *waiting); };
}

// A client that disconnects ends its comparison, unless that is durable.
std::optional<Clock::time_point> Comparisons::look(Exchange& exchange, Waiting& waiting) {
  LiveJob& job = *waiting.job;
  if (exchange.client_gone && !job.durable && !job.is_over() && jobs_.abandon(waiting.job)) {
    answer(exchange, cancelled_early());
    return std::nullopt;
  }
  if (!job.is_over()) jobs_.end_if_over(job);
  if (job.is_over() || (waiting.until && Clock::now() >= *waiting.until)) {
    respond(exchange, job.view(), waiting.terms);
    return std::nullopt;
  }
  if (const auto problem = jobs_.give_up(job)) {
    if (!job.durable) jobs_.abandon(waiting.job);
    answer(exchange, *problem);
    return std::nullopt;
  }
  if (exchange.client_gone && job.durable) {
    accept(exchange, job.view(), waiting.terms);  // for the log; the client has gone
    return std::nullopt;
  }
  return next_look(waiting);
}

// The job's end is signalled; its deadline in the queue, and a store that is away, are not.
Clock::time_point Comparisons::next_look(const Waiting& waiting) const {
  const auto now = Clock::now();
  const auto deadline = waiting.job->deadline();
  const auto next = jobs_.store_queue() || deadline <= now ? now + kWaitTick : deadline;
  return waiting.until ? std::min(next, *waiting.until) : next;
}

void Comparisons::add_headers(Exchange& exchange, const JobView& job, const Terms& terms) {
  auto& headers = exchange.response.headers;
  const std::string& applied = exchange.preferences.applied;
  if (!applied.empty()) headers.emplace_back("Preference-Applied", applied);
  if (terms.durable) headers.emplace_back("Location", "/v1/comparisons/" + job.row.key.id);
}

void Comparisons::accept(Exchange& exchange, const JobView& job, const Terms& terms) const {
  add_headers(exchange, job, terms);
  answer_with(exchange, to_json(job), 202);
}

void Comparisons::respond(Exchange& exchange, const JobView& job, const Terms& terms) const {
  const bool ended = store::has_ended(job.row.state);
  if (!ended && exchange.preferences.wait) return accept(exchange, job, terms);
  add_headers(exchange, job, terms);
  if (!ended) {
    return answer(exchange,
                  Problem{ProblemKind::shutting_down,
                          terms.durable ? "the service is shutting down; the comparison is stored and runs later"
                                        : "the service is shutting down; send the request again"});
  }
  exchange.stages = job.stages;
  exchange.triangles = job.triangles;
  if (job.row.document.empty()) {
    return answer_stored(exchange, job.row, jobs_.expected_wait(kind_of(exchange.preferences)));
  }
  answer_with(exchange, result_json(job.row));
  if (!job.timing.empty()) exchange.response.headers.emplace_back("Server-Timing", job.timing);
}

void Comparisons::get(Exchange& exchange) {
  const auto job = jobs_.get(job_key_of(exchange));
  if (!job) return answer(exchange, api::to_problem(job.error()));
  if (!*job) return answer(exchange, not_found("comparison"));
  answer_with(exchange, to_json(**job));
}

void Comparisons::remove(Exchange& exchange) {
  const auto removed = jobs_.remove(job_key_of(exchange));
  if (!removed) return answer(exchange, api::to_problem(removed.error()));
  if (*removed == Jobs::Deleted::unknown) return answer(exchange, not_found("comparison"));
  if (*removed == Jobs::Deleted::asked_to_end) return get(exchange);
  exchange.response.status = 204;
}

void Comparisons::cancel(Exchange& exchange) {
  const auto ended = jobs_.cancel(job_key_of(exchange));
  if (!ended) return answer(exchange, api::to_problem(ended.error()));
  get(exchange);
}

void Comparisons::events(Exchange& exchange) {
  const auto key = job_key_of(exchange);
  const auto first = jobs_.get(key);
  if (!first) return answer(exchange, api::to_problem(first.error()));
  if (!*first) return answer(exchange, not_found("comparison"));
  const auto place = take_place(exchange, watchers_, settings_);
  if (!place) return;
  exchange.response.content_type = "text/event-stream";
  exchange.response.length_known = false;
  if (exchange.head.method == "HEAD") return;
  follow_events(exchange, jobs_.watch(**first), place);
}

// Null: the job has ended. Its last row is then the only event; none, if it was deleted or cannot be read.
void Comparisons::follow_events(Exchange& exchange, const std::shared_ptr<LiveJob>& job,
                                const std::shared_ptr<const void>& place) {
  Response& response = exchange.response;
  if (!job) {
    response.stream = [this, key = job_key_of(exchange), place](std::string& piece) {
      const auto last = jobs_.get(key);
      if (last && *last) piece = event("end", to_json(**last));
      return std::optional<Clock::time_point>();
    };
    return;
  }
  response.quick = true;
  response.stream = [job, place, &rows = stores_.jobs, listening = job->on_change(exchange.wake),
                     seen = ~std::uint64_t{0},
                     next = Clock::time_point()](std::string& piece) mutable -> std::optional<Clock::time_point> {
    const auto now = Clock::now();
    if (now < next) return next;
    const auto version = job->version();
    const auto view = job->view();
    const bool over = store::has_ended(view.row.state);
    if (!over && view.handed_back) return std::nullopt;  // the service stops; the job ends elsewhere
    if (!over && version == seen) return now + kQuiet;
    seen = version;
    next = now + kProgressGap;
    piece = over ? event("end", to_json(view)) : event("progress", progress_json(view, rows.time()));
    return over ? std::nullopt : std::optional(next);
  };
}

void read_options(Exchange& exchange, const Settings& settings) {
  std::string_view type = exchange.head.header("content-type");
  if (take_kind(type) != "application/json") {
    constexpr const char* kWanted = "Content-Type must be application/json, the options of a comparison";
    return answer(exchange, api::Problem{api::ProblemKind::unsupported_media_type, kWanted});
  }
  const auto text = std::make_shared<std::string>();
  exchange.body.read([text](std::string_view piece) { return add_piece(*text, piece); },
                     [&exchange, text, limits = request_limits(settings)](const auto& lost) {
                       if (lost) return answer(exchange, *lost);
                       const auto request = api::parse_options(*text, limits);
                       if (!request) return answer(exchange, api::to_problem(request.error()));
                       answer_with(exchange, api::json_of(*request).dump());
                     });
}

}  // namespace meshgauge::server
