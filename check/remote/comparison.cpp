#include "check/remote/comparison.h"

#include <algorithm>
#include <span>
#include <thread>
#include <utility>

namespace meshgauge::check::service {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

constexpr int kWaitSeconds = 1;  // for the answer to the first request; most comparisons end within it

class PlaceTaken {
 public:
  explicit PlaceTaken(AdaptiveLimit& limit) : limit_(limit) {}
  ~PlaceTaken() { limit_.give_back(); }
  PlaceTaken(const PlaceTaken&) = delete;
  PlaceTaken& operator=(const PlaceTaken&) = delete;

 private:
  AdaptiveLimit& limit_;
};

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

HttpRequest job_request(const char* method, const std::string& id) { return {method, "/v1/comparisons/" + id, {}}; }

bool is(const std::optional<Problem>& problem, const char* slug) { return problem && problem->slug == slug; }

}  // namespace

Result<Json> Comparison::measure() {
  for (;;) {
    auto end = attempt();
    if (!end) return end.error();
    if (end->document) return std::move(*end->document);
    if (control_.check() == Interruption::cancelled) return cancelled();
    if (again(*end)) continue;
    if (end->problem) return error_of(*end->problem, pair_.gate(), client_.base());
    return Error{ErrorCode::internal, "the service at " + client_.base() + " has lost the comparison", "", "--server"};
  }
}

// Whether to submit the comparison again, with a new key, since the old key stands for the old result. Not after a
// timeout, which would occur again.
bool Comparison::again(const End& end) {
  if (is(end.problem, "unknown-mesh")) return pair_.forget(end.problem->part);
  return end.lost && attempts_ < kAttempts;
}

Result<End> Comparison::attempt() {
  if (const auto ok = pair_.send(); !ok) return ok.error();
  document_ = document_of(pair_.asked());
  if (!limit_.take(control_)) return cancelled();
  const PlaceTaken place(limit_);
  ++attempts_;
  control_.report({0, Progress{}.upper, "queue"});
  const auto reply = client_.ask(request(kWaitSeconds), control_, [&] { limit_.refused(); });
  if (reply) return answered(*reply);
  return control_.check() == Interruption::cancelled ? abandon(reply.error()) : reply.error();
}

HttpRequest Comparison::request(int wait) const {
  return {"POST",
          "/v1/comparisons",
          {{"Content-Type", "application/json"},
           {"Prefer", "respond-async, wait=" + std::to_string(wait)},
           {"Idempotency-Key", key_ + "." + std::to_string(attempts_)}},
          bytes_of(document_)};
}

Result<End> Comparison::answered(const HttpAnswer& reply) {
  End end;
  if (reply.status == 200) {
    end.document = comparison_from(reply.body);
    if (end.document && pair_.is_ours(*end.document)) return end;
  }
  if (reply.status == 202) {
    if (const auto job = job_from(reply.body)) return follow(job->id);
  }
  end.problem = problem_from(std::string_view(reply.body));
  if (is(end.problem, "unknown-mesh") || is(end.problem, "out-of-time")) return end;
  return unexpected(reply);
}

Error Comparison::unexpected(const HttpAnswer& reply) const {
  if (reply.status >= 300) return error_of(reply, pair_.gate(), client_.base(), client_.has_key());
  return not_a_service(client_.base(), "its answer is not that to this comparison");
}

// Polls the comparison until it has ended, through restarts of the service and of proxies.
Result<End> Comparison::follow(const std::string& id) {
  const auto wall = Clock::now() + pair_.gate().request.timeout + client_.retry_time();
  milliseconds interval = kFirstPoll;
  while (pause(interval, control_) && Clock::now() < wall) {
    const auto reply = client_.ask(job_request("GET", id), control_);
    if (control_.check() == Interruption::cancelled) break;
    if (!reply) return reply.error();
    End end;
    end.lost = reply->status == 404;
    if (end.lost) return end;
    auto job = reply->status == 200 ? job_from(reply->body) : std::nullopt;
    if (!job) return unexpected(*reply);
    if (take(std::move(*job), end)) return end;
    interval = std::min(kLastPoll, interval * 3 / 2);
  }
  return cancel(id, after(client_.cancel_time()));
}

// True: it has ended, see `end`. Progress never widens, also if the work begins again after a restart.
bool Comparison::take(Job job, End& end) {
  if (job.ended()) {
    end = pair_.end_of(std::move(job));
    return true;
  }
  progress_ = {std::max(progress_.lower, job.progress.lower), std::min(progress_.upper, job.progress.upper),
               job.progress.stage};
  control_.report(progress_);
  return false;
}

// Cancels the comparison and reads its interval so far. If the answer to DELETE is lost, the comparison is polled: a
// second DELETE would remove the result.
Result<End> Comparison::cancel(const std::string& id, const Interrupted& over) {
  End end;
  for (HttpRequest request = job_request("DELETE", id); !over(); request = job_request("GET", id)) {
    const HttpAnswer reply = client_.once(request, over);
    const bool gone = reply.status == 204 || reply.status == 404;
    if (gone || reply.trouble == Trouble::no_contact) break;
    auto job = reply.status == 200 ? job_from(reply.body) : std::nullopt;
    if (job && take(std::move(*job), end)) break;
    std::this_thread::sleep_for(kCancelPoll);
  }
  if (end.document) return end;
  if (control_.check() == Interruption::cancelled) return cancelled();
  return Error{ErrorCode::internal, "the service at " + client_.base() + " did not end the comparison in its time", "",
               "--server"};
}

// Cancelled while the comparison was being submitted: submits it again with the same key, which returns the same
// comparison, and cancels that.
Result<End> Comparison::abandon(const Error& why) {
  const Interrupted over = after(client_.cancel_time());
  const HttpAnswer reply = client_.once(request(0), over);
  End end;
  if (reply.status == 200) end.document = comparison_from(reply.body);
  if (end.document && pair_.is_ours(*end.document)) return end;
  auto job = reply.status == 202 ? job_from(reply.body) : std::nullopt;
  if (!job) return why;
  const std::string id = job->id;
  if (take(std::move(*job), end) && end.document) return end;
  return cancel(id, over);
}

}  // namespace meshgauge::check::service
