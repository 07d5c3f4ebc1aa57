#include "check/remote/client.h"

#include <random>
#include <utility>

#include "check/remote/answer.h"
#include "check/remote/retry.h"
#include "check/remote/waiting.h"

namespace meshgauge::check::service {
namespace {

using Clock = Control::Clock;

double random_part() {
  thread_local std::mt19937_64 generator{std::random_device{}()};
  return std::uniform_real_distribution<double>(0, 1)(generator);
}

// A comparison that ended without an interval is answered as if by a service that is busy.
bool is_out_of_time(const Reply& reply) {
  if (reply.status != 503) return false;
  const auto problem = problem_from(std::string_view(reply.body));
  return problem && problem->slug == "out-of-time";
}

}  // namespace

Error cancelled() { return {ErrorCode::out_of_time, "cancelled before there was an interval", "", ""}; }

Client::Client(const RemoteOptions& options, const std::string& base)
    : access_{base,
              options.key,
              !options.key.empty() && !options.key_in_clear && base.starts_with("http://"),
              options.ca_file.string(),
              options.connect_timeout,
              options.stall},
      patience_(options.patience),
      first_contact_(options.first_contact) {}

Result<Reply> Client::ask(const Call& call, Control& control, const std::function<void()>& refused) {
  Retries retries(patience_, first_contact_);
  const auto interrupted = [&] { return control.check() == Interruption::cancelled; };
  for (;;) {
    if (auto known = known_trouble()) return *known;
    Exchange exchange = once(call, interrupted);
    if (exchange.trouble == Trouble::cancelled) return cancelled();
    if (exchange.trouble == Trouble::none && is_out_of_time(exchange.reply)) return std::move(exchange.reply);
    const bool busy = exchange.reply.status == 429 || exchange.reply.status == 503;
    if (busy && refused) refused();
    const auto wait = retries.after(exchange, reached_, Clock::now(), random_part());
    if (!wait && exchange.trouble == Trouble::none) return std::move(exchange.reply);
    if (!wait) return no_reply(exchange);
    if (!pause(*wait, control)) return cancelled();
  }
}

Exchange Client::once(const Call& call, const Interrupted& interrupted) {
  auto connection = take();
  Exchange exchange = connection->send(call, interrupted);
  if (exchange.trouble == Trouble::none) reached_ = true;
  if (exchange.trouble == Trouble::none) give_back(std::move(connection));
  return exchange;
}

std::unique_ptr<Connection> Client::take() {
  const std::lock_guard lock(mutex_);
  if (idle_.empty()) return std::make_unique<Connection>(access_);
  auto connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void Client::give_back(std::unique_ptr<Connection> connection) {
  const std::lock_guard lock(mutex_);
  idle_.push_back(std::move(connection));
}

std::optional<Error> Client::known_trouble() {
  if (reached_) return std::nullopt;
  const std::lock_guard lock(mutex_);
  return never_reached_;
}

Error Client::no_reply(const Exchange& exchange) {
  const bool silent = exchange.trouble == Trouble::no_contact;
  const std::string what = silent ? "the service at " + access_.base + " cannot be reached: "
                                  : "the service at " + access_.base + " does not answer: ";
  Error error{ErrorCode::internal, what + exchange.why, "", "--server"};
  const std::lock_guard lock(mutex_);
  if (!reached_) never_reached_ = error;
  return error;
}

}  // namespace meshgauge::check::service
