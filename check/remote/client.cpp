#include "check/remote/client.h"

#include <random>
#include <utility>

#include "check/remote/address.h"
#include "check/remote/answer.h"
#include "check/remote/retry.h"
#include "check/remote/waiting.h"
#include "engine/hausdorff.h"

namespace meshgauge::check::service {
namespace {

using Clock = Control::Clock;

constexpr long kHardlyMoves = 1000;  // bytes per second

double random_part() {
  thread_local std::mt19937_64 generator{std::random_device{}()};
  return std::uniform_real_distribution<double>(0, 1)(generator);
}

// A comparison that ended without an interval has the same status as a busy service.
bool is_out_of_time(const HttpAnswer& answer) {
  if (answer.status != 503) return false;
  const auto problem = problem_from(std::string_view(answer.body));
  return problem && problem->slug == "out-of-time";
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

}  // namespace

Error cancelled() { return {ErrorCode::out_of_time, "cancelled before there was an interval", "", ""}; }

Client::Client(const RemoteOptions& options, const std::string& base)
    : http_(http_settings(options, base)),
      retry_time_(options.retry_time),
      first_contact_(options.first_contact),
      cancel_time_(options.cancel_time) {}

Result<HttpAnswer> Client::ask(const HttpRequest& request, Control& control, const std::function<void()>& refused) {
  Retries retries(retry_time_, first_contact_);
  const auto interrupted = [&] { return control.check() == Interruption::cancelled; };
  for (;;) {
    if (auto known = known_trouble()) return *known;
    HttpAnswer answer = once(request, interrupted);
    if (answer.trouble == Trouble::cancelled) return cancelled();
    if (is_out_of_time(answer)) return answer;
    if (refused && (answer.status == 429 || answer.status == 503)) refused();
    const auto wait = retries.after(answer, reached_, Clock::now(), random_part());
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
