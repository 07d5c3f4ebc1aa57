// PostgresStore: hand-backs, recovery, counts and sweeps.
#include "server/store/postgres/postgres_store.h"
#include "server/store/rows.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

constexpr auto kLockHeld = "SELECT" + kLossColumns + R"sql(
    FROM (SELECT $1 AS owner, $2 AS id, $3 AS worker, $4 AS tries) AS given CROSS JOIN jobs
    WHERE )sql" + kHeld + " FOR NO KEY UPDATE OF jobs";
// Skips locked rows: a heartbeat or an end is just being stored.
constexpr auto kLockLost =
    "SELECT" + kLossColumns + " FROM jobs WHERE " + kLost + " ORDER BY owner, id FOR NO KEY UPDATE SKIP LOCKED";
constexpr auto kHandBackJobs = "UPDATE jobs SET" + kHandBack + R"sql(
    FROM unnest($4::int8[], $5::int8[], $6::int8[]) AS given (number, state, excused)
    WHERE jobs.number = given.number)sql";

void hand_back(PgConnection& connection, const std::vector<LostJob>& lost, const std::string& why, Moment moment) {
  if (lost.empty()) return;
  std::vector<std::int64_t> numbers, states, excused;
  for (const LostJob& job : lost) {
    numbers.push_back(job.number);
    states.push_back(static_cast<std::int64_t>(job.after.state));
    excused.push_back(job.after.excused);
  }
  connection.query(kHandBackJobs, why, moment.now, moment.keep_until, numbers, states, excused);
}

constexpr auto kGiveUpSome = R"sql(
    WITH locked AS MATERIALIZED (
      SELECT number FROM jobs WHERE )sql" +
                             kNeverRun + R"sql(
      ORDER BY owner, id LIMIT $3 FOR NO KEY UPDATE SKIP LOCKED)
    UPDATE jobs SET)sql" + kGiveUp +
                             R"sql(
    FROM locked WHERE jobs.number = locked.number
    RETURNING owner, id, batch)sql";

struct GivenUp {
  std::uint64_t jobs = 0;
  std::vector<JobKey> to_tell;  // jobs of no batch
};

GivenUp give_up_waiting(PgConnection& connection, Moment moment) {
  PgRows row = connection.query(kGiveUpSome, moment.now, moment.keep_until, kPortion);
  GivenUp given_up;
  while (row.next()) {
    ++given_up.jobs;
    if (row.bytes(2).empty()) given_up.to_tell.push_back({row.text(0), row.text(1)});
  }
  return given_up;
}

// Removes the ended jobs of this condition that are not locked; returns their number.
template <std::size_t kSize>
constexpr auto delete_jobs(const Sql<kSize>& condition) {
  return "DELETE FROM jobs WHERE number = ANY (ARRAY(SELECT number FROM jobs WHERE state >= 2 AND " + condition +
         " FOR UPDATE SKIP LOCKED))";
}

constexpr auto kRemoveSomeExpired = delete_jobs(kExpired + " LIMIT $2");
constexpr auto kRemoveSomeBeyondShare = delete_jobs("owner = $1 ORDER BY" + kGoesFirst + " LIMIT $2");
constexpr auto kForget = delete_jobs(Sql("owner = $1 AND id = $2"));

std::uint64_t remove_beyond_share(PgConnection& connection, std::uint64_t max_kept, std::int64_t most) {
  std::uint64_t removed = 0;
  for (const auto& [owner, jobs] : beyond_share(count_kept(connection), max_kept, static_cast<std::uint64_t>(most))) {
    removed += connection.query(kRemoveSomeBeyondShare, owner, jobs).changed();
  }
  return removed;
}

}  // namespace

Result<bool> PostgresStore::forget(const JobKey& key) {
  if (behind_.find(key)) {
    Result<Done> flushed = flush();
    if (!flushed) return flushed.error();
  }
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    return connection.query(kForget, key.owner, key.id).changed() == 1;
  });
}

void PostgresStore::tell_handed_back(const JobKey& key, JobState state, bool in_batch) {
  if (state == JobState::queued) control_.tell(Signal::Kind::work);
  if (has_ended(state) && !in_batch) control_.tell(Signal::Kind::changed, key);
}

Result<std::optional<JobState>> PostgresStore::hand_back(const Token& token, const std::string& last_error,
                                                         Moment moment) {
  const auto back = pool_.run(Promise::durable, [&](PgConnection& connection) {
    PgTransaction transaction(connection);
    auto lost = lost_jobs(connection.query(kLockHeld, token.key.owner, token.key.id, token.worker, token.tries), false,
                          last_error);
    store::hand_back(connection, lost, last_error, moment);
    transaction.commit();
    return lost;
  });
  if (!back) return back.error();
  if (back->empty()) return std::optional<JobState>();
  const LostJob& job = back->front();
  tell_handed_back(job.key, job.after.state, job.loss.in_batch);
  return std::optional(job.after.state);
}

Result<std::vector<Job>> PostgresStore::recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                                Moment moment) {
  const auto lost = pool_.run(
      Promise::durable,
      [&](PgConnection& connection) {
        PgTransaction transaction(connection);
        auto dead = lost_jobs(connection.query(kLockLost, dead_workers, moment.now), true, why);
        store::hand_back(connection, dead, why, moment);
        transaction.commit();
        return dead;
      },
      kLonger);
  if (!lost) return lost.error();
  for (const LostJob& job : *lost) tell_handed_back(job.key, job.after.state, job.loss.in_batch);
  if (const Result<Done> rest = cancel_the_rest(moment); !rest) return rest.error();
  return std::vector<Job>();
}

Result<std::vector<BlobKey>> PostgresStore::used_blobs() {
  return pool_.run(Promise::fleeting, find_used_blobs<PgConnection>, kLonger);
}

Result<std::vector<BlobKey>> PostgresStore::known_blobs() {
  return pool_.run(Promise::fleeting, find_known_blobs<PgConnection>, kLonger);
}

Result<std::uint64_t> PostgresStore::remove_in_portions(
    const std::function<std::uint64_t(PgConnection&, std::int64_t most)>& remove) {
  std::uint64_t removed = 0;
  while (true) {
    Result<std::uint64_t> portion = pool_.run(
        Promise::durable, [&](PgConnection& connection) { return remove(connection, kPortion); }, kLonger);
    if (!portion) return portion;
    removed += *portion;
    if (*portion < kPortion) return removed;
  }
}

Result<SweptJobs> PostgresStore::sweep_jobs(Moment moment, std::uint64_t max_kept) {
  SweptJobs swept;
  const auto given_up = remove_in_portions([&](PgConnection& connection, std::int64_t) {
    const GivenUp some = give_up_waiting(connection, moment);
    for (const JobKey& key : some.to_tell) control_.tell(Signal::Kind::changed, key);
    return some.jobs;
  });
  if (!given_up) return given_up.error();
  swept.given_up = *given_up;
  const auto expired = remove_in_portions([&](PgConnection& connection, std::int64_t most) {
    return connection.query(kRemoveSomeExpired, moment.now, most).changed();
  });
  if (!expired) return expired.error();
  swept.expired = *expired;
  const auto over_cap = remove_in_portions(
      [&](PgConnection& connection, std::int64_t most) { return remove_beyond_share(connection, max_kept, most); });
  if (!over_cap) return over_cap.error();
  swept.over_cap = *over_cap;
  return swept;
}

}  // namespace meshgauge::server::store
