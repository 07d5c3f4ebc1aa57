// The connections of a process to its database, and how what it asks survives a failover.
//
// One thread opens connections, so that nobody who calls waits for a name server or a host that is silent. A call that
// fails for a reason that may pass is repeated on another connection, until `call_timeout` is over: a failover of a
// second or two is not noticed. While the database has been gone for longer, calls fail at once, and that thread tries
// again and again. A database that has no more connections to give is not gone: those that there are go round.
//
// What a caller is told may be told to anybody: it names no host, no role and no statement. The whole text goes to the
// report.
//
// So work is done more than once: each must be idempotent. A commit whose answer was lost may have happened; the
// repetition then finds it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>

#include "server/store/outage.h"
#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

struct PoolSettings {
  std::string database;  // connection string
  std::size_t max_connections = 8;
  std::chrono::milliseconds call_timeout{4000};
  Report report = {};
  std::chrono::milliseconds fair_time{1000};  // for an answer: a server that takes longer may be gone
};

// What a caller is told of a failure.
Error plain_error(const PgFailure& failure);

// What a work's success promises: `durable` that it outlives the machine it was stored on, also when an earlier try's
// commit was never acknowledged; `fleeting` not.
enum class Promise { durable, fleeting };

class PgPool {
 public:
  explicit PgPool(PoolSettings settings);
  ~PgPool();

  // work(PgConnection&), which may throw PgFailure; what it returns. It is called again when that may help. `longer`:
  // how many times the call_timeout a large work gets. Thread safe.
  template <class Work>
  auto run(Promise promise, Work work, int longer = 1) -> Result<std::invoke_result_t<Work&, PgConnection&>> {
    std::optional<std::invoke_result_t<Work&, PgConnection&>> value;
    Result<Done> done = run_until(
        promise, [&](PgConnection& connection) { value.emplace(work(connection)); },
        std::chrono::steady_clock::now() + longer * settings_.call_timeout);
    if (!done) return done.error();
    return *std::move(value);
  }

  // When the database was last not to be reached, or a connection was lost; the start of this object, if never.
  SteadyTime newest_trouble() const;
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
  void open_one(std::unique_lock<std::mutex>& lock);

  const PoolSettings settings_;
  mutable std::mutex mutex_;
  std::condition_variable returned_;  // a connection, or the news that there is none
  std::condition_variable wanted_;    // by the thread that opens them
  std::deque<std::unique_ptr<PgConnection>> idle_;
  std::size_t open_ = 0;     // idle or taken
  std::size_t waiting_ = 0;  // callers
  std::optional<SteadyTime> gone_since_;
  SteadyTime newest_trouble_ = std::chrono::steady_clock::now();
  SteadyTime newest_success_{};  // of a work, or of opening a connection
  std::string why_gone_;
  std::string why_no_more_;  // connections, beside those that are open; empty: the newest try opened one
  bool stopped_ = false;
  Outage outage_;
  std::thread opener_;
};

}  // namespace meshgauge::server::store
