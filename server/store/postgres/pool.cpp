#include "server/store/postgres/pool.h"

#include <algorithm>
#include <thread>

#include "server/base/heap.h"

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kBetweenProbes = 250ms;
constexpr auto kFirstPause = 5ms, kLongestPause = 200ms;  // between tries of one call

constexpr const char* kNoneToSpare = "53300";  // SQLSTATE: too many connections
constexpr const char* kBusy = "all connections to it are busy";

constexpr const char* kSilent = "it did not answer in time";  // as in connection.cpp
constexpr const char* kUnreplicated = "no other server has confirmed what was stored";

const char* trouble_of(const PgFailure& failure) {
  const std::string& state = failure.state;
  if (state == "57014" || state == "55P03" || failure.message == kSilent || failure.message == kUnreplicated) {
    return "did not answer in time";
  }
  if (state.starts_with("40")) return "is busy";
  if (state.starts_with("53")) return "has no free connection";
  if (state.starts_with("28") || state.starts_with("3D") || state == "42501") return "refuses this service";
  return "cannot be reached";
}

}  // namespace

Error plain_error(const PgFailure& failure) {
  Error error = to_error(failure);
  const std::string what = "the database ";
  if (error.code == ErrorCode::storage_full) {
    error.message = what + "has no room";
  } else if (error.code == ErrorCode::storage_unavailable) {
    error.message = what + trouble_of(failure);
  } else {
    error.message = what + "failed (" + failure.state + ")";
  }
  return error;
}

PgPool::PgPool(PoolSettings settings)
    : settings_(std::move(settings)), outage_("the database", settings_.report), opener_([this] { tell_end(); }) {
  opener_.start([this] { open_connections(); });
}

void PgPool::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wanted_.notify_all();
  returned_.notify_all();
}

SteadyTime PgPool::newest_trouble() const {
  const std::lock_guard lock(mutex_);
  return newest_trouble_;
}

Result<Done> PgPool::run_until(Promise promise, const std::function<void(PgConnection&)>& work, SteadyTime deadline) {
  bool repeated = false;
  const auto guarded = [&](PgConnection& connection) {
    work(connection);
    if (repeated && promise == Promise::durable) connection.put_barrier();
  };
  for (auto pause = Clock::duration(kFirstPause);; pause = std::min<Clock::duration>(2 * pause, kLongestPause)) {
    const std::optional<PgFailure> failure = attempt(guarded, deadline);
    if (!failure) {
      outage_.over();
      return Done{};
    }
    if (!failure->may_pass || Clock::now() + pause >= deadline) {
      tell(to_error(*failure));
      return plain_error(*failure);
    }
    repeated = true;
    std::this_thread::sleep_for(pause);
  }
}

// A statement that the database rejects is a defect, and no outage.
void PgPool::tell(const Error& error) {
  if (error.code != ErrorCode::internal) return outage_.failed(error.message);
  if (settings_.report) settings_.report(error.message);
}

std::optional<PgFailure> PgPool::attempt(const std::function<void(PgConnection&)>& work, SteadyTime deadline) {
  std::unique_ptr<PgConnection> connection;
  SteadyTime taken{};
  try {
    connection = take(deadline);
    taken = Clock::now();
    connection->set_deadline(deadline);
    work(*connection);
    note_success();
    give_back(std::move(connection));
    return std::nullopt;
  } catch (const PgFailure& failure) {
    if (connection) {
      // A caller that waited long for a connection has little time left for the answer: no sign of an outage.
      const bool hurried = failure.message == kSilent && Clock::now() - taken < settings_.fair_time;
      if (!connection->usable() && !hurried) lose(failure.message);
      give_back(std::move(connection));
    }
    return failure;
  } catch (...) {
    if (connection) give_back(std::move(connection));
    throw;
  }
}

bool PgPool::is_given_up() const { return gone_since_ && Clock::now() - *gone_since_ >= settings_.call_timeout; }

std::unique_ptr<PgConnection> PgPool::take(SteadyTime deadline) {
  std::unique_lock lock(mutex_);
  while (true) {
    if (!idle_.empty()) {
      std::unique_ptr<PgConnection> connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
    if (stopped_) throw PgFailure{"", "the service ends", true, false};
    if (is_given_up()) throw PgFailure{"", why_gone_, true, false};
    ++waiting_;
    wanted_.notify_one();
    const bool in_time = returned_.wait_until(lock, deadline) == std::cv_status::no_timeout;
    --waiting_;
    if (!in_time) {
      if (!idle_.empty()) returned_.notify_one();  // this caller may have taken the notification
      throw none_in_time();
    }
  }
}

PgFailure PgPool::none_in_time() const {
  if (gone_since_) return {"", why_gone_, true, false};
  return {kNoneToSpare, why_no_more_.empty() ? kBusy : why_no_more_, true, false};
}

void PgPool::give_back(std::unique_ptr<PgConnection> connection) {
  const bool sound = connection->usable() && !connection->in_transaction();
  if (!sound) connection.reset();
  {
    const std::lock_guard lock(mutex_);
    if (connection) {
      idle_.push_back(std::move(connection));
    } else {
      --open_;
    }
  }
  returned_.notify_one();
  if (!sound) wanted_.notify_one();
}

void PgPool::note_success() {
  const std::lock_guard lock(mutex_);
  newest_success_ = Clock::now();
  gone_since_.reset();
}

// Drops the idle connections, too: they are likely to be of the server that was lost.
void PgPool::lose(const std::string& why) {
  std::deque<std::unique_ptr<PgConnection>> lost;
  const std::lock_guard lock(mutex_);
  newest_trouble_ = Clock::now();
  why_gone_ = why;
  lost.swap(idle_);
  open_ -= lost.size();
}

void PgPool::open_connections() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    const bool needed = gone_since_ || (waiting_ > idle_.size() && open_ < settings_.max_connections);
    if (!needed) {
      wanted_.wait(lock);
    } else {
      open_one(lock);
    }
  }
}

void PgPool::open_one(std::unique_lock<std::mutex>& lock) {
  std::unique_ptr<PgConnection> connection;
  std::string why;
  lock.unlock();
  try {
    connection = PgConnection::open(settings_.database);
  } catch (const PgFailure& failure) {
    why = failure.message;
  }
  lock.lock();
  const bool opened = connection != nullptr;
  why_no_more_ = why;
  if (opened) {
    newest_success_ = Clock::now();
    gone_since_.reset();
    ++open_;
    idle_.push_back(std::move(connection));
  } else if (open_ == 0 || Clock::now() - newest_success_ >= settings_.call_timeout) {
    newest_trouble_ = Clock::now();
    if (!gone_since_) gone_since_ = newest_trouble_;
    why_gone_ = why;
  }
  returned_.notify_all();
  if (!opened) wanted_.wait_for(lock, kBetweenProbes, [this] { return stopped_; });
}

}  // namespace meshgauge::server::store
