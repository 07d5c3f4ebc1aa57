#include "server/store/postgres/control.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <span>

#include "api/base/digest.h"
#include "server/base/heap.h"

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kStatementTime = 4s;
constexpr auto kPing = 5s;
constexpr auto kApplyAgain = 1s;  // after which another process takes over the duty
constexpr auto kBetweenConnects = 500ms;
constexpr std::size_t kMostPending = 10'000;
constexpr std::int64_t kDuty = 0x4d474a32;  // a lock; with the hash of the schema's name a pair of numbers

std::int64_t ns(Clock::duration time) { return std::chrono::duration_cast<std::chrono::nanoseconds>(time).count(); }

// Payloads: "<kind> <owner> <id>", owner and id in hexadecimal digits.
constexpr std::string_view kKinds = "wcxm";  // in the order of Signal::Kind
constexpr std::string_view kDigits = "0123456789abcdef";
constexpr std::size_t kLongest = 7000;  // PostgreSQL takes less than 8000 bytes

std::string hex_of(const std::string& text) { return api::to_hex(std::as_bytes(std::span(text))); }

std::optional<std::string> text_of(std::string_view hex) {
  if (hex.size() % 2 != 0 || hex.find_first_not_of(kDigits) != std::string_view::npos) return std::nullopt;
  std::string text;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    text += static_cast<char>(kDigits.find(hex[i]) << 4 | kDigits.find(hex[i + 1]));
  }
  return text;
}

}  // namespace

std::string to_payload(const Signal& signal) {
  const std::string kind(1, kKinds[static_cast<std::size_t>(signal.kind)]);
  std::string payload = kind + " " + hex_of(signal.job.owner) + " " + hex_of(signal.job.id);
  return payload.size() <= kLongest ? payload : to_payload({Signal::Kind::missed, {}});
}

std::optional<Signal> signal_of(std::string_view payload) {
  const std::size_t second = payload.find(' ', 2);
  if (payload.size() < 3 || payload[1] != ' ' || second == std::string_view::npos) return std::nullopt;
  const std::size_t kind = kKinds.find(payload.front());
  auto owner = text_of(payload.substr(2, second - 2));
  auto id = text_of(payload.substr(second + 1));
  if (kind == std::string_view::npos || !owner || !id) return std::nullopt;
  return Signal{static_cast<Signal::Kind>(kind), {*std::move(owner), *std::move(id)}};
}

std::int64_t clock_offset_ns(PgConnection& connection) {
  const SteadyTime before = Clock::now();
  PgRows row = connection.query("SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::int8");
  const SteadyTime after = Clock::now();
  row.next();
  const SteadyTime middle = before + (after - before) / 2;
  return row.number(0) * 1000 - ns(middle.time_since_epoch());
}

PgControl::PgControl(ControlSettings settings, const ConnectionHealth& others)
    : settings_(std::move(settings)),
      others_(others),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)),
      connected_since_(Clock::now().time_since_epoch().count()),
      time_offset_ns_(settings_.time_offset_ns),
      threads_([this] { tell_end(); }) {
  threads_.start([this] { work(); });
}

void PgControl::tell_end() {
  stopped_ = true;
  ::eventfd_write(wake_.get(), 1);
}

void PgControl::listen(Hear hear) {
  const std::lock_guard lock(hear_mutex_);
  hear_ = std::move(hear);
}

void PgControl::stop_listening() {
  const std::lock_guard lock(hear_mutex_);
  hear_ = nullptr;
}

void PgControl::hear(const Signal& signal) {
  const std::lock_guard lock(hear_mutex_);
  if (hear_) hear_(signal);
}

void PgControl::tell(Signal::Kind kind, const JobKey& job) {
  std::string payload = to_payload({kind, job});
  {
    const std::lock_guard lock(pending_mutex_);
    if (pending_.size() >= kMostPending) return;
    if (!pending_.empty() && pending_.back() == payload) return;
    pending_.push_back(std::move(payload));
  }
  ::eventfd_write(wake_.get(), 1);
}

// By the steady clock, so that setting this machine's clock changes nothing.
TimePoint PgControl::time() const {
  const auto since_1970 = std::chrono::nanoseconds(ns(Clock::now().time_since_epoch()) + time_offset_ns_.load());
  return std::chrono::floor<std::chrono::milliseconds>(std::chrono::sys_time<std::chrono::nanoseconds>(since_1970));
}

bool PgControl::on_duty() {
  if (asked_.exchange(Clock::now().time_since_epoch().count()) == 0) ::eventfd_write(wake_.get(), 1);
  return holds_duty_.load() && is_well();
}

bool PgControl::applies() const {
  const std::int64_t asked = asked_.load();
  return asked != 0 && Clock::now() - SteadyTime(Clock::duration(asked)) < settings_.duty_lapse;
}

bool PgControl::is_well() const {
  const SteadyTime connected{Clock::duration(connected_since_.load())};
  return Clock::now() - std::max(connected, others_.newest_trouble()) >= settings_.duty_grace;
}

void PgControl::work() {
  const NeverFails never_fails;
  bool was_connected = false;
  while (!stopped_) {
    try {
      connect();
      if (was_connected) hear({Signal::Kind::missed, {}});
      was_connected = true;
      while (!stopped_) serve();
    } catch (const PgFailure&) {  // the pool reports errors to callers; here a new connection is opened
    }
    holds_duty_ = false;
    connection_.reset();
    pause();
  }
}

void PgControl::connect() {
  connection_ = PgConnection::open(settings_.database);
  connection_->set_deadline(Clock::now() + kStatementTime);
  // A process that is stopped must not keep its duty: without a statement every kPing the server ends its session.
  connection_->execute("SET idle_session_timeout = '30s'; SET synchronous_commit = off");
  // Several schemas of one database may be in use.
  PgRows schema = connection_->query("SELECT 'meshgauge_' || md5(coalesce(current_schema(), ''))");
  schema.next();
  channel_ = schema.text(0);
  connection_->execute("LISTEN " + channel_);
  measure_time();
  applied_ = {};
  connected_since_ = Clock::now().time_since_epoch().count();
}

void PgControl::serve() {
  std::array<pollfd, 2> polled{{{connection_->socket(), POLLIN, 0}, {wake_.get(), POLLIN, 0}}};
  const auto timeout = static_cast<int>(std::chrono::milliseconds(asked_ != 0 ? kApplyAgain : kPing).count());
  ::poll(polled.data(), polled.size(), timeout);
  eventfd_t count = 0;
  if (polled[1].revents != 0) ::eventfd_read(wake_.get(), &count);
  if (stopped_) return;
  connection_->set_deadline(Clock::now() + kStatementTime);
  send_pending();
  if (asked_ != 0) seek_duty();
  if (Clock::now() - measured_at_ >= kPing) measure_time();
  hear_all();
}

void PgControl::send_pending() {
  std::deque<std::string> pending;
  {
    const std::lock_guard lock(pending_mutex_);
    pending.swap(pending_);
  }
  if (pending.empty()) return;
  // NOTIFY holds a lock of the whole database until its commit. So it has a transaction of its own, which waits for no
  // disk, and not the callers' transactions.
  const std::vector<std::string> payloads(pending.begin(), pending.end());
  connection_->query(
      "SELECT pg_notify(encode($1, 'escape'), encode(payload, 'escape')) FROM unnest($2::bytea[]) AS payload", channel_,
      payloads);
}

// Leaves the duty when the other connections of this process fail or cannot be opened, or when upkeep hangs: this
// connection alone may be well, and would keep the duty from processes that can do it.
void PgControl::seek_duty() {
  const bool fit = is_well() && applies();
  if (holds_duty_ && !fit) return leave_duty();
  if (!holds_duty_ && fit && Clock::now() - applied_ >= kApplyAgain) apply_for_duty();
}

void PgControl::leave_duty() {
  holds_duty_ = false;
  connection_->query("SELECT pg_advisory_unlock($1::int, hashtext(coalesce(current_schema(), '')))", kDuty);
}

void PgControl::apply_for_duty() {
  applied_ = Clock::now();
  PgRows row =
      connection_->query("SELECT pg_try_advisory_lock($1::int, hashtext(coalesce(current_schema(), '')))", kDuty);
  holds_duty_ = row.next() && row.number(0) != 0;
}

void PgControl::measure_time() {
  time_offset_ns_ = clock_offset_ns(*connection_);
  measured_at_ = Clock::now();
}

void PgControl::hear_all() {
  for (const PgConnection::Notification& notification : connection_->notifications()) {
    if (const auto signal = signal_of(notification.payload)) hear(*signal);
  }
}

void PgControl::pause() {
  pollfd polled{wake_.get(), POLLIN, 0};
  const auto end = Clock::now() + kBetweenConnects;
  while (!stopped_ && Clock::now() < end) {
    ::poll(&polled, 1, 50);
    eventfd_t count = 0;
    if (polled.revents != 0) ::eventfd_read(wake_.get(), &count);
    const std::lock_guard lock(pending_mutex_);
    pending_.clear();  // listeners get `missed` when they reconnect
  }
}

}  // namespace meshgauge::server::store
