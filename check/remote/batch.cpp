#include "check/remote/batch.h"

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <span>
#include <thread>
#include <utility>

#include "api/base/text.h"
#include "api/base/utf8.h"
#include "api/options/batch_request.h"

namespace meshgauge::check::service {
namespace {

using Json = nlohmann::ordered_json;
using std::chrono::milliseconds;

// Each read sends all results, so they are read again when an eighth of them has ended since the last read, or after
// kReadEvery.
constexpr std::size_t kShareOfRead = 8;
constexpr std::chrono::seconds kReadEvery{5};
constexpr milliseconds kTimeOfLine{200};  // for each result, in the time limit of the exchange that reads them
// Preference of the first poll: it is answered when a comparison has ended, at the latest after a second; most small
// pairs end within it. Later polls are answered at once, since few clients may wait at a service.
constexpr const char* kFirstPollWaits = "wait=1";
// Between two polls: the first; then half as much again each time, up to the last.
constexpr milliseconds kFirstPoll{50}, kLastPoll{1000};
constexpr milliseconds kCancelPoll{50};
// How often it may change whether anything runs before a comparison has to end: a service tries each some times and
// then fails it. One that is broken could change it for ever.
constexpr int kMostChanges = 16;

std::string path_of(const std::string& id) { return "/v1/batches/" + id; }

// A name is for people only: results are identified by their positions.
bool can_be_named(const std::string& name) {
  return !name.empty() && name.size() <= api::kMaxBatchNameBytes && is_utf8(name) &&
         find_control(name) == std::string::npos;
}

bool is_any_of(int status, std::initializer_list<int> statuses) {
  return std::find(statuses.begin(), statuses.end(), status) != statuses.end();
}

}  // namespace

void BatchResults::begin() {
  line_.clear();
  next_ = 0;
}

bool BatchResults::take(std::string_view piece) {
  for (std::size_t end = piece.find('\n'); end != std::string_view::npos; end = piece.find('\n')) {
    if (end > kMostReplyBytes - line_.size()) return false;
    line_.append(piece.substr(0, end));
    if (!take_line(line_)) return false;
    line_.clear();
    piece.remove_prefix(end + 1);
  }
  if (piece.size() > kMostReplyBytes - line_.size()) return false;
  line_.append(piece);
  return true;
}

bool BatchResults::take_line(std::string_view text) {
  auto line = batch_line_from(text);
  if (!line || line->position < next_ || line->position >= comparisons_) return false;
  next_ = line->position + 1;
  sink_(std::move(*line));
  return true;
}

Batch::Outcome Batch::measure() {
  if (control_.check() == Interruption::cancelled) return {Fate::failed, cancelled()};
  document_ = document();
  const auto reply = client_.ask(request(), control_, longest());
  if (reply) return answered(*reply);
  if (control_.check() == Interruption::cancelled) return abandon();
  return {Fate::failed, reply.error()};
}

std::string Batch::document() const {
  Json comparisons = Json::array();
  for (const Pair* pair : pairs_) {
    Json asked = pair->asked();
    if (can_be_named(pair->gate().name)) asked["name"] = pair->gate().name;
    comparisons.push_back(std::move(asked));
  }
  const Json batch{{"name", "meshgauge check"}, {"comparisons", std::move(comparisons)}};
  return batch.dump(-1, ' ', false, Json::error_handler_t::replace);
}

HttpRequest Batch::request() const {
  return {"POST",
          "/v1/batches",
          {{"Content-Type", "application/json"}, {"Idempotency-Key", key_}},
          std::as_bytes(std::span(document_))};
}

Batch::Outcome Batch::answered(const HttpAnswer& reply) {
  if (const auto batch = reply.status == 202 ? ours(reply) : std::nullopt) {
    if (!batch->view.empty()) listener_.begun(batch->view);
    return follow(batch->id);
  }
  if (is_any_of(reply.status, {400, 413, 422})) return refused(reply);
  const bool older = is_any_of(reply.status, {404, 405, 501}) && problem_from(std::string_view(reply.body));
  if (!older) return failed(reply);
  const std::string what =
      "the service at " + client_.base() + " has no batches, since it is older than this program: update the service";
  return {Fate::failed, Error{ErrorCode::internal, what, "", "--server"}};
}

// The service names a mesh by its id, and the place of an option in the whole batch.
Batch::Outcome Batch::refused(const HttpAnswer& reply) const {
  constexpr std::string_view kOptions = "/comparisons/0/options";
  auto problem = problem_from(std::string_view(reply.body));
  if (problem && problem->slug == "unknown-mesh") {
    problem->detail = "the mesh '" + problem->part + "' is not stored, though it was sent";
    problem->where.clear();
    return {Fate::unknown_mesh, error_of(*problem, pairs_.front()->gate(), client_.base())};
  }
  Error error = failed(reply).error;
  if (error.where.starts_with(kOptions)) error.where.erase(0, kOptions.size());
  return {Fate::refused, std::move(error)};
}

Batch::Outcome Batch::lost() const {
  const std::string what = "the service at " + client_.base() + " has lost the comparison";
  return {Fate::lost, Error{ErrorCode::internal, what, "", "--server"}};
}

Batch::Outcome Batch::failed(const HttpAnswer& reply) const {
  if (reply.status < 300) return {Fate::failed, not_a_service(client_.base(), "its answer is not that to this batch")};
  return {Fate::failed, error_of(reply, pairs_.front()->gate(), client_.base(), client_.has_key())};
}

std::optional<BatchState> Batch::ours(const HttpAnswer& reply) const {
  auto batch = batch_from(reply.body);
  return batch && batch->total == pairs_.size() ? batch : std::nullopt;
}

// Polls the batch until it has ended, through restarts of the service and of proxies.
Batch::Outcome Batch::follow(const std::string& id) {
  std::size_t ended = 0;
  bool runs = false;
  int changes = 0;
  read_ = Clock::now();
  milliseconds interval = kFirstPoll;
  HttpRequest request{"GET", path_of(id), {{"Prefer", kFirstPollWaits}}};
  for (auto wall = Clock::now() + slack(runs); Clock::now() < wall;) {
    const auto reply = client_.ask(request, control_, longest());
    if (control_.check() == Interruption::cancelled) return cancel(id);
    if (!reply) return {Fate::failed, reply.error()};
    if (reply->status == 404) return lost();
    const auto batch = reply->status == 200 ? ours(*reply) : std::nullopt;
    if (!batch || batch->id != id) return failed(*reply);
    for (const auto& [place, progress] : batch->running) pairs_[place]->report(progress);
    const bool did_run = std::exchange(runs, !batch->running.empty());
    if (batch->ended > ended) changes = 0;
    if (batch->ended > ended || (runs != did_run && ++changes <= kMostChanges)) wall = Clock::now() + slack(runs);
    ended = std::max(ended, batch->ended);
    const auto there = batch->finished || due(*batch) ? read(id) : Result<Done>(Done{});
    if (control_.check() == Interruption::cancelled) return cancel(id);
    if (!there) return {Fate::failed, there.error()};
    if (batch->finished) return lost();
    request.headers.clear();
    if (!pause(interval, control_)) return cancel(id);
    interval = std::min(kLastPoll, interval * 3 / 2);
  }
  cancel(id);
  const std::string what = "the service at " + client_.base() + " did not end the batch in its time";
  return {Fate::failed, Error{ErrorCode::internal, what, "", "--server"}};
}

bool Batch::due(const BatchState& batch) const {
  if (batch.ended <= known_) return false;
  return batch.ended - known_ >= std::max<std::size_t>(pairs_.size() / kShareOfRead, 1) ||
         Clock::now() >= read_ + kReadEvery;
}

// How long nothing may change. What runs ends by its time limit; before that, comparisons of others may come first.
milliseconds Batch::slack(bool runs) const {
  return 2 * longest() + (runs ? client_.patience(longest()) : client_.retry_time());
}

milliseconds Batch::longest() const {
  milliseconds longest{0};
  for (const Pair* pair : pairs_) longest = std::max(longest, pair->gate().request.timeout);
  return longest;
}

HttpRequest Batch::results_request(const std::string& id, BatchResults& results) const {
  HttpRequest request{"GET", path_of(id) + "/results.jsonl", {}};
  request.limit += kTimeOfLine * pairs_.size();
  request.begin = [&results] { results.begin(); };
  request.take = [&results](int, std::span<const std::byte> piece) -> Result<Done> {
    if (results.take(api::as_text(piece))) return Done{};
    return Error{ErrorCode::internal, "its answer is not what was asked for", "", ""};
  };
  return request;
}

// If the batch is forgotten meanwhile, the next poll notices.
Result<Done> Batch::read(const std::string& id) {
  BatchResults results(pairs_.size(), [this](BatchLine line) { take(std::move(line)); });
  const auto reply = client_.ask(results_request(id, results), control_, longest());
  read_ = Clock::now();
  if (!reply) return reply.error();
  if (reply->status != 200 && reply->status != 404) return failed(*reply).error;
  return Done{};
}

// A line that is neither a result nor a problem is skipped; its gate has no result.
void Batch::take(BatchLine line) {
  if (reported_[line.position] || !line.end) return;
  End& end = *line.end;
  if (end.document && !pairs_[line.position]->is_ours(*end.document)) end.document.reset();
  if (!end.document && !end.problem) return;
  reported_[line.position] = true;
  ++known_;
  listener_.ended(line.position, std::move(end));
}

// Cancelled while the batch was being submitted: submits it again with the same key, which returns the same batch,
// and cancels that.
Batch::Outcome Batch::abandon() {
  const HttpAnswer reply = client_.once(request(), after(client_.cancel_time()));
  const auto batch = reply.status == 202 ? ours(reply) : std::nullopt;
  return batch ? cancel(batch->id) : Outcome{Fate::failed, cancelled()};
}

// Cancels the batch and reads its results, with the intervals of comparisons that had begun. A quarter of the time is
// left for the results of those that have ended, if others do not end.
Batch::Outcome Batch::cancel(const std::string& id) {
  const Interrupted over = after(client_.cancel_time());
  end_there(id, after(client_.cancel_time() * 3 / 4));
  BatchResults results(pairs_.size(), [this](BatchLine line) { take(std::move(line)); });
  client_.once(results_request(id, results), over);
  return {Fate::failed, cancelled()};
}

void Batch::end_there(const std::string& id, const Interrupted& over) {
  for (HttpRequest request{"POST", path_of(id) + "/cancel", {}}; !over(); std::this_thread::sleep_for(kCancelPoll)) {
    const HttpAnswer reply = client_.once(request, over);
    if (reply.status == 404 || reply.trouble == Trouble::no_contact) return;
    const auto batch = reply.status == 200 ? ours(reply) : std::nullopt;
    if (batch && batch->finished) return;
    if (batch) request = {"GET", path_of(id), {}};
  }
}

}  // namespace meshgauge::check::service
