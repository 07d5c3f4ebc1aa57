#include "check/remote/client.h"

#include <algorithm>
#include <cstdint>
#include <random>

#include "check/remote/address.h"
#include "engine/hausdorff.h"

namespace meshgauge::check::service {
namespace {

using Clock = Control::Clock;
using std::chrono::milliseconds;

constexpr long kHardlyMoves = 1000;      // bytes per second
constexpr milliseconds kLeastTry{1000};  // for an answer

constexpr RetriedStatus kRetried[] = {
    {408, 3},            // the upload was too slow
    {429, 0},            // the key's rate or number of jobs
    {500, 3},            // a proxy's failure, or a defect
    {502, 0},            // a proxy whose service restarts
    {503, 0},            // the queue is full, or the service shuts down
    {504, 0}, {507, 3},  // 507: the disk is full
};

const RetriedStatus* row_of(int status) {
  for (const RetriedStatus& row : kRetried) {
    if (row.status == status) return &row;
  }
  return nullptr;
}

double random_part() {
  thread_local std::mt19937_64 generator{std::random_device{}()};
  return std::uniform_real_distribution<double>(0, 1)(generator);
}

net::HttpSettings http_settings(const RemoteOptions& options, const std::string& base) {
  net::HttpSettings http;
  http.base = base;
  http.key = options.key;
  http.user_agent = std::string("meshgauge/") + version();
  http.ca_file = options.ca_file.string();
  http.without_proxy = !options.key.empty() && !options.key_in_clear && base.starts_with("http://");
  http.early_refusals = true;
  http.connect = options.connect_timeout;
  http.stall = options.stall;
  http.least_speed = kHardlyMoves;
  http.most_body = kMostReplyBytes;
  return http;
}

// Whether it may take long though all is well.
bool is_large(const HttpRequest& request) {
  constexpr std::size_t kMuch = std::size_t{64} << 10;  // bytes
  return request.take || request.body.size() > kMuch;
}

// The request, to end at `end`. A large one has its own time limit, and may stand still for `most`.
HttpRequest within(HttpRequest request, Clock::time_point end, milliseconds most) {
  if (is_large(request)) {
    request.stall = std::chrono::ceil<std::chrono::seconds>(most);
  } else {
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    request.limit = std::clamp(left, kLeastTry, request.limit);
  }
  return request;
}

}  // namespace

std::span<const RetriedStatus> retried_statuses() { return kRetried; }

std::optional<Retries::Milliseconds> Retries::after(const net::HttpAnswer& failed, bool reached, Clock::time_point now,
                                                    double random) {
  if (failed.trouble == net::Trouble::hopeless || failed.trouble == net::Trouble::cancelled) return std::nullopt;
  ++tries_;
  if (failed.trouble == net::Trouble::none) {
    const RetriedStatus* row = row_of(failed.status);
    if (!row || (row->tries && tries_ >= row->tries)) return std::nullopt;
  }
  since_ = since_.value_or(now);
  const Milliseconds doubled = kFirst * (1 << std::min(tries_ - 1, 16));
  Milliseconds pause(
      static_cast<std::int64_t>(static_cast<double>(std::min(doubled, kMost).count()) * (1 + random) / 2));
  if (failed.retry_after) pause = std::max<Milliseconds>(pause, *failed.retry_after);
  if (now + pause > *since_ + (reached ? retry_time_ : first_contact_)) return std::nullopt;
  return pause;
}

Error cancelled() { return {ErrorCode::out_of_time, "cancelled before there was an interval", "", ""}; }

Client::Client(const RemoteOptions& options, const std::string& base)
    : http_(http_settings(options, base)),
      retry_time_(options.retry_time),
      first_contact_(options.first_contact),
      least_patience_(options.least_patience),
      cancel_time_(options.cancel_time) {}

Result<HttpAnswer> Client::ask(const HttpRequest& request, Control& control, milliseconds timeout) {
  const milliseconds most = patience(timeout);
  const auto end = Clock::now() + most;
  Retries retries(std::min(retry_time_, most), std::min(first_contact_, most));
  const auto interrupted = [&] { return control.check() == Interruption::cancelled; };
  for (;;) {
    if (auto known = known_trouble()) return *known;
    HttpAnswer answer = once(within(request, end, most), interrupted);
    if (answer.trouble == Trouble::cancelled) return cancelled();
    auto wait = retries.after(answer, reached_, Clock::now(), random_part());
    if (wait && !is_large(request) && Clock::now() + *wait >= end) wait.reset();
    if (!wait && answer.trouble == Trouble::none) return answer;
    if (!wait) return no_reply(answer);
    if (!pause(*wait, control)) return cancelled();
  }
}

HttpAnswer Client::once(const HttpRequest& request, const Interrupted& interrupted) {
  HttpAnswer answer = http_.perform(request, interrupted);
  if (answer.trouble == Trouble::none) reached_ = true;
  return answer;
}

std::optional<Error> Client::known_trouble() {
  if (reached_) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return never_reached_;
}

Error Client::no_reply(const HttpAnswer& answer) {
  const std::string& ca_file = http_.settings().ca_file;
  const bool of_ca_file = !ca_file.empty() && answer.why.find(ca_file) != std::string::npos;
  const bool silent = answer.trouble == Trouble::no_contact;
  const std::string what =
      silent ? "the service at " + base() + " cannot be reached: " : "the service at " + base() + " does not answer: ";
  Error error{ErrorCode::internal, what + one_line(answer.why) + (of_ca_file ? " (--ca-file)" : ""), "", "--server"};
  const std::lock_guard lock(mutex_);
  if (!reached_) never_reached_ = error;
  return error;
}

}  // namespace meshgauge::check::service
