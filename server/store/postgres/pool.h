// The connections of a process to its database. Calls survive a short failover.
//
// One thread opens connections, so no caller waits for a name server or a silent host. A call that fails for a reason
// that may pass is repeated on another connection until `call_timeout` is over, so callers do not notice a failover of
// one or two seconds. When the database has been away for longer, calls fail at once, and that thread keeps trying. A
// database that grants no further connection is not away: callers share those that are open.
//
// Work may therefore run more than once, and must be idempotent. A commit whose answer was lost may have happened; the
// repetition finds it.
//
// Errors for callers name no host, no role and no statement; the report gets the whole text.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <type_traits>

#include "server/base/threads.h"
#include "server/store/outage.h"
#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

struct PoolSettings {
  std::string database;  // connection string
  std::size_t max_connections = 8;
  std::chrono::milliseconds call_timeout{4000};
  Report report = {};
  std::chrono::milliseconds fair_time{1000};  // for an answer; a slower server may be away
};

inline constexpr int kLonger = 5;  // times the call_timeout, for calls that read, write or remove much

// The error for callers: storage_unavailable without details, or internal.
Error plain_error(const PgFailure& failure);

// durable: successful work survives the loss of the machine that stored it, also when the commit of an earlier try was
// never acknowledged. fleeting: it may be lost.
enum class Promise { durable, fleeting };

// What PgControl asks about the other connections of its process. Thread safe.
class ConnectionHealth {
 public:
  virtual ~ConnectionHealth() = default;

  // When the database was last unreachable, or a connection was lost; the start of this object if never.
  virtual SteadyTime newest_trouble() const = 0;
};

class PgPool final : public ConnectionHealth {
 public:
  explicit PgPool(PoolSettings settings);
  ~PgPool() override = default;

  // Returns the value of work(PgConnection&), which may throw PgFailure and is repeated when that may help. Blocks for
  // at most `longer` times the call_timeout. Thread safe.
  template <class Work>
  auto run(Promise promise, Work work, int longer = 1) -> Result<std::invoke_result_t<Work&, PgConnection&>> {
    std::optional<std::invoke_result_t<Work&, PgConnection&>> value;
    Result<Done> done = run_until(
        promise, [&](PgConnection& connection) { value.emplace(work(connection)); },
        std::chrono::steady_clock::now() + longer * settings_.call_timeout);
    if (!done) return done.error();
    return *std::move(value);
  }

  SteadyTime newest_trouble() const override;
  const PoolSettings& settings() const { return settings_; }

 private:
  Result<Done> run_until(Promise promise, const std::function<void(PgConnection&)>& work, SteadyTime deadline);
  void tell(const Error& error);
  std::optional<PgFailure> attempt(const std::function<void(PgConnection&)>& work, SteadyTime deadline);
  std::unique_ptr<PgConnection> take(SteadyTime deadline);  // throws PgFailure
  PgFailure none_in_time() const;
  void give_back(std::unique_ptr<PgConnection> connection);
  void note_success();
  void lose(const std::string& why);
  bool is_given_up() const;
  void open_connections();
  void tell_end();
  void open_one(std::unique_lock<std::mutex>& lock);

  const PoolSettings settings_;
  mutable std::mutex mutex_;
  std::condition_variable returned_;  // a connection is idle, or the database is away
  std::condition_variable wanted_;    // a connection is to be opened
  std::deque<std::unique_ptr<PgConnection>> idle_;
  std::size_t open_ = 0;     // idle or taken
  std::size_t waiting_ = 0;  // callers
  std::optional<SteadyTime> gone_since_;
  SteadyTime newest_trouble_ = std::chrono::steady_clock::now();
  SteadyTime newest_success_{};  // of work, or of opening a connection
  std::string why_gone_;
  std::string why_no_more_;  // why no further connection can be opened; empty: the newest attempt opened one
  bool stopped_ = false;
  Outage outage_;
  Threads opener_;
};

}  // namespace meshgauge::server::store
