#include "server/handlers/comparisons.h"

#include <algorithm>
#include <memory>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/refused.h"
#include "server/access/entrance.h"
#include "server/handlers/comparison_form.h"
#include "server/handlers/refusals.h"
#include "server/http/event_stream.h"
#include "server/http/idempotency.h"
#include "server/http/multipart.h"
#include "server/http/parameters.h"
#include "server/jobs/job_document.h"

namespace meshgauge::server {
namespace {

using api::not_found;
using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr milliseconds kWaitTick{20};      // between two checks for a disconnected client
constexpr milliseconds kProgressGap{100};  // between two events of a stream

store::JobKey job_key_of(const Exchange& exchange) { return {exchange.owner, exchange.segment}; }

// Answers for a comparison that ended without a result. The worker stores its problem as JSON text; a job that was
// cancelled in the queue, or that the store gave up, has none.
void answer_stored(Exchange& exchange, const store::Job& row) {
  if (row.problem.empty() && row.state == store::JobState::cancelled) {
    return answer(exchange, cancelled_early());
  }
  if (row.problem.empty()) return answer(exchange, Problem{ProblemKind::internal, "given up: " + row.last_error, {}});
  const auto json = nlohmann::json::parse(row.problem, nullptr, false);
  if (!json.is_object()) return answer(exchange, Problem{ProblemKind::internal, "the comparison failed", {}});
  answer(exchange, {json.value("status", 500), json.value("type", ""), row.problem}, std::chrono::seconds(1));
}

}  // namespace

// A POST, as far as it is parsed.
struct Comparisons::Post {
  Preferences preferences;
  Clock::time_point since = Clock::now();
  bool repeats = false;  // a comparison with its Idempotency-Key is stored
  Submission submission;
};

Comparisons::Comparisons(const Settings& settings, Jobs& jobs, Stores stores, Access& access, ByteBudget& uploads)
    : settings_(settings),
      jobs_(jobs),
      stores_(stores),
      access_(access),
      uploads_(uploads),
      watchers_(ConnectionLimit::shared(settings.max_event_streams)) {}

void Comparisons::create(Exchange& exchange) {
  if (draining_.load()) return answer(exchange, shutting_down());
  Post post;
  post.preferences = preferences(exchange.head);
  Submission& submission = post.submission;
  submission.key = {exchange.owner, exchange.id};
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  if (auto refusal = read_idempotency_key(exchange.head, submission.idempotency_key)) return answer(exchange, *refusal);
  submission.durable = post.preferences.wait || !submission.idempotency_key.empty();
  if (const auto there = jobs_.available(); !there) return answer(exchange, api::to_problem(there.error()));
  const auto repeats = jobs_.repeats(submission);
  if (!repeats) return answer(exchange, api::to_problem(repeats.error()));
  if (*repeats) return repeat(exchange, post);
  admit(exchange, post);
}

// The comparison that took the last place may be this request, sent before and stored meanwhile. false: it is not.
bool Comparisons::repeat_if_known(Exchange& exchange, Post& post) {
  const auto repeats = jobs_.repeats(post.submission);
  if (!repeats || !*repeats) return false;
  repeat(exchange, post);
  return true;
}

void Comparisons::admit(Exchange& exchange, Post& post) {
  Submission& submission = post.submission;
  // Without a preference the client waits for the result and occupies a connection.
  auto slot = jobs_.admit(post.preferences.wait ? Jobs::Kind::durable : Jobs::Kind::awaited);
  if (!slot) {
    if (repeat_if_known(exchange, post)) return;
    return answer(exchange, queue_full(), jobs_.expected_wait());
  }
  auto counted = access_.take_job(exchange.owner);
  if (const auto* denial = std::get_if<Denial>(&counted)) {
    slot.reset();
    if (!repeat_if_known(exchange, post)) answer(exchange, *denial);
    return;
  }
  submission.counted.emplace(std::get<JobSlot>(std::move(counted)));
  submission.trace = traceparent(exchange.trace);
  if (auto refusal = receive(exchange, post)) return answer(exchange, *refusal);
  follow(exchange, jobs_.submit(std::move(*slot), std::move(submission)), post);
}

// A comparison that was accepted before needs no place in the queue, no storage and no stored meshes, and is not
// refused for lack of them.
void Comparisons::repeat(Exchange& exchange, Post& post) {
  post.repeats = true;
  if (auto refusal = receive(exchange, post)) return answer(exchange, *refusal);
  follow(exchange, jobs_.repeated(post.submission), post);
}

void Comparisons::follow(Exchange& exchange, const Jobs::Submitted& submitted, const Post& post) {
  if (const auto* denial = std::get_if<Denial>(&submitted)) return answer(exchange, *denial);
  if (const auto* job = std::get_if<std::shared_ptr<LiveJob>>(&submitted)) return wait(exchange, *job, post);
  respond(exchange, std::get<JobView>(submitted), post);
}

std::optional<Problem> Comparisons::receive(Exchange& exchange, Post& post) {
  std::string_view type = exchange.head.header("content-type");
  const bool ids = take_kind(type) == "application/json";
  if (auto refusal = ids ? receive_ids(exchange, post) : receive_form(exchange, post)) return refusal;
  auto request = api::parse_options(post.submission.options, request_limits(settings_));
  if (!request) return api::to_problem(request.error());
  post.submission.request = *request;
  return std::nullopt;
}

std::optional<Problem> Comparisons::receive_form(Exchange& exchange, Post& post) {
  std::string boundary;
  constexpr const char* kWanted = "multipart/form-data, with the parts a, b and options";
  if (auto refusal = find_boundary(exchange.head.header("content-type"), kWanted, boundary)) return refusal;
  Form form;
  FormReceiver receiver(form, settings_, uploads_);
  MultipartParser parser(boundary, receiver);
  if (auto refusal = exchange.body.read([&](std::string_view piece) { return parser.feed(piece); })) return refusal;
  if (auto refusal = parser.finish()) return refusal;
  if (auto refusal = receiver.complete()) return refusal;
  post.submission.options = std::move(form.options);
  post.submission.a = source_of("a", std::move(form.a));
  post.submission.b = source_of("b", std::move(form.b));
  return std::nullopt;
}

std::optional<Problem> Comparisons::receive_ids(Exchange& exchange, Post& post) {
  std::string text;
  const auto refusal = exchange.body.read([&](std::string_view piece) -> std::optional<Problem> {
    if (text.size() + piece.size() > api::kMaxOptionsBytes) {
      return Problem{ProblemKind::too_large,
                     "the body is larger than the limit of " + std::to_string(api::kMaxOptionsBytes) + " bytes",
                     {}};
    }
    text.append(piece);
    return std::nullopt;
  });
  if (refusal) return refusal;
  auto pair = api::parse_stored_pair(text);
  if (!pair) return api::to_problem(pair.error());
  post.submission.options = std::move(pair->options);
  post.submission.a.id = std::move(pair->a);
  post.submission.b.id = std::move(pair->b);
  if (post.repeats) return std::nullopt;
  if (auto missing = open_mesh(exchange.owner, "a", post.submission.a)) return missing;
  return open_mesh(exchange.owner, "b", post.submission.b);
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

// A client that disconnects ends its comparison, unless that is durable.
void Comparisons::wait(Exchange& exchange, const std::shared_ptr<LiveJob>& waited, const Post& post) {
  LiveJob& job = *waited;
  // A client that does not want to wait needs no place, and gets a 202 even if the job has already ended.
  if (post.preferences.wait == milliseconds(0)) return accept(exchange, job.view(), post);
  std::optional<Clock::time_point> until;
  std::shared_ptr<const void> place;
  const bool repeated =
      job.key.id != exchange.id;  // an earlier request with this Idempotency-Key holds the queue place
  if (post.preferences.wait || repeated) place = watchers_.take(exchange.owner);
  if (post.preferences.wait) until = place ? post.since + *post.preferences.wait : Clock::now();
  if (repeated && !until && !place) {
    return answer(exchange, too_many_watchers(settings_));
  }
  const auto tick = [&] {
    return until ? std::min(kWaitTick, std::chrono::ceil<milliseconds>(*until - Clock::now())) : kWaitTick;
  };
  while (!job.wait_for_end(tick())) {
    if (until && Clock::now() >= *until) break;
    jobs_.end_if_over(job);
    if (const auto problem = jobs_.give_up(job)) {
      if (!job.durable) jobs_.abandon(waited);
      return answer(exchange, *problem);
    }
    if (!exchange.connection.peer_gone()) continue;
    if (job.durable) return accept(exchange, job.view(), post);  // for the log; the client has gone
    if (jobs_.abandon(waited)) return answer(exchange, cancelled_early());
  }
  respond(exchange, job.view(), post);
}

void Comparisons::add_headers(Exchange& exchange, const JobView& job, const Post& post) const {
  auto& headers = exchange.response.headers;
  if (!post.preferences.applied.empty()) headers.emplace_back("Preference-Applied", post.preferences.applied);
  if (post.submission.durable) headers.emplace_back("Location", "/v1/comparisons/" + job.row.key.id);
}

void Comparisons::accept(Exchange& exchange, const JobView& job, const Post& post) const {
  add_headers(exchange, job, post);
  exchange.response.status = 202;
  exchange.response.content_type = "application/json";
  exchange.response.body = to_json(job);
}

void Comparisons::respond(Exchange& exchange, const JobView& job, const Post& post) const {
  const bool ended = store::has_ended(job.row.state);
  if (!ended && post.preferences.wait) return accept(exchange, job, post);
  add_headers(exchange, job, post);
  if (!ended) {
    return answer(exchange, Problem{ProblemKind::shutting_down,
                                    post.submission.durable
                                        ? "the service is shutting down; the comparison is stored and runs later"
                                        : "the service is shutting down; send the request again",
                                    {}});
  }
  Response& response = exchange.response;
  exchange.stages = job.stages;
  exchange.triangles = job.triangles;
  if (job.row.document.empty()) return answer_stored(exchange, job.row);
  response.content_type = "application/json";
  response.body = result_json(job.row);
  if (!job.timing.empty()) response.headers.emplace_back("Server-Timing", job.timing);
}

void Comparisons::get(Exchange& exchange) {
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  const auto job = jobs_.get(job_key_of(exchange));
  if (!job) return answer(exchange, api::to_problem(job.error()));
  if (!*job) return answer(exchange, not_found("comparison"));
  exchange.response.content_type = "application/json";
  exchange.response.body = to_json(**job);
}

void Comparisons::remove(Exchange& exchange) {
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  const auto removed = jobs_.remove(job_key_of(exchange));
  if (!removed) return answer(exchange, api::to_problem(removed.error()));
  if (*removed == Jobs::Deleted::unknown) return answer(exchange, not_found("comparison"));
  if (*removed == Jobs::Deleted::asked_to_end) return get(exchange);
  exchange.response.status = 204;
}

void Comparisons::events(Exchange& exchange) {
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  const auto key = job_key_of(exchange);
  const auto first = jobs_.get(key);
  if (!first) return answer(exchange, api::to_problem(first.error()));
  if (!*first) return answer(exchange, not_found("comparison"));
  if (exchange.head.minor_version == 0) {
    return answer(exchange, Problem{ProblemKind::http_version, "this path streams its response: send HTTP/1.1", {}});
  }
  const auto place = watchers_.take(exchange.owner);
  if (!place) return answer(exchange, too_many_watchers(settings_));
  exchange.response.content_type = "text/event-stream";
  exchange.response.length_known = false;
  if (exchange.head.method == "HEAD") return;
  const auto job = jobs_.watch(**first);
  exchange.response.stream = [this, key, place, job, seen = ~std::uint64_t{0},
                              next = Clock::time_point()](std::string& piece) mutable {
    if (job) {
      std::this_thread::sleep_until(std::min(next, Clock::now() + kProgressGap));
      job->wait_for_change(seen, kProgressGap);
      const auto version = job->version();
      const auto view = job->view();
      const bool over = store::has_ended(view.row.state);
      if (!over && view.handed_back) return false;  // the service stops; the job ends elsewhere
      if (!over && version == seen) return true;
      seen = version;
      next = Clock::now() + kProgressGap;
      piece = over ? event("end", to_json(view)) : event("progress", progress_json(view));
      return !over;
    }
    const auto last = jobs_.get(key);
    piece = last && *last ? event("end", to_json(**last)) : event("end", "null");
    return false;
  };
}

}  // namespace meshgauge::server
