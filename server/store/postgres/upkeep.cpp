// PostgresStore: what looks at many jobs at once.
#include <algorithm>

#include "server/store/policy.h"
#include "server/store/postgres/job_rows.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kPortion = 500;  // rows that one transaction ends or removes
constexpr int kLonger = 5;              // of the call_timeout: what reads or removes much

// What an item of a batch points at stays as long as the batch, whenever it expires.
#define MESHGAUGE_PG_IN_NO_BATCH \
  "NOT EXISTS (SELECT FROM batch_items AS item WHERE item.owner = jobs.owner AND item.job = jobs.id)"

// Removes ended jobs that are not locked. A condition on the jobs, which may have a limit, stands between the pieces.
#define MESHGAUGE_PG_REMOVE "DELETE FROM jobs WHERE number = ANY (ARRAY(SELECT number FROM jobs WHERE state >= 2 AND "
#define MESHGAUGE_PG_UNLOCKED " FOR UPDATE SKIP LOCKED))"

// A running job that is to be handed back, and is locked.
struct Lost {
  std::int64_t number = 0;
  JobKey key;
  Loss loss;
  AfterLoss after{};
};

constexpr const char* kOfToken =
    "SELECT number, owner, id, tries, excused, cancel_requested, batch <> '', stage IS NOT NULL FROM jobs WHERE owner "
    "= $1 AND id = $2 AND state + 0 = 1 AND worker = $3 AND tries = $4 FOR NO KEY UPDATE";
// A row that is locked is one whose worker is just being heard.
constexpr const char* kOfTheDead =
    "SELECT number, owner, id, tries, excused, cancel_requested, batch <> '', stage IS NOT NULL FROM jobs WHERE state "
    "= 1 AND CASE WHEN $1 IS NULL THEN lease_until <= $2 ELSE substr(worker, 1, length($1)) = $1 END ORDER BY owner, "
    "id FOR NO KEY UPDATE SKIP LOCKED";

std::vector<Lost> lost_jobs(PgRows row) {
  std::vector<Lost> all;
  while (row.next()) {
    const Loss loss{static_cast<unsigned>(row.number(3)), static_cast<unsigned>(row.number(4)), row.number(5) != 0,
                    row.number(6) != 0, row.number(7) != 0};
    all.push_back({row.number(0), {row.text(1), row.text(2)}, loss});
  }
  return all;
}

// The last error of an excused one stays.
void hand_back(PgConnection& connection, const std::vector<Lost>& lost, const std::string& why, Moment moment) {
  if (lost.empty()) return;
  std::vector<std::int64_t> numbers, states, excused;
  for (const Lost& job : lost) {
    numbers.push_back(job.number);
    states.push_back(static_cast<std::int64_t>(job.after.state));
    excused.push_back(job.after.excused);
  }
  connection.query(
      "UPDATE jobs SET state = mine.state, worker = '', lease_until = NULL, finished = CASE WHEN mine.state >= 2 THEN "
      "$5 END, expires = CASE WHEN mine.state >= 2 THEN $6 END, excused = mine.excused, last_error = CASE WHEN "
      "mine.excused > jobs.excused THEN last_error ELSE $4 END FROM unnest($1::int8[], $2::int8[], $3::int8[]) AS mine "
      "(number, state, excused) WHERE jobs.number = mine.number",
      numbers, states, excused, why, moment.now, moment.keep_until);
}

std::vector<Lost> hand_back_dead(PgConnection& connection, const std::optional<std::string>& dead_workers,
                                 const std::string& why, Moment moment) {
  PgTransaction transaction(connection);
  auto dead = lost_jobs(connection.query(kOfTheDead, dead_workers, moment.now));
  for (Lost& job : dead) job.after = why.empty() ? after_hand_back(job.loss, true) : after_loss(job.loss);
  hand_back(connection, dead, why, moment);
  transaction.commit();
  return dead;
}

void add(Counts& counts, JobState state, std::uint64_t number) {
  std::uint64_t* const fields[] = {&counts.queued, &counts.running, &counts.done, &counts.failed, &counts.cancelled};
  *fields[static_cast<std::size_t>(state)] = number;
}

void add_waiting(PgConnection& connection, Counts& counts) {
  PgRows row = connection.query(
      "SELECT (SELECT count(*) FROM jobs WHERE state IN (0, 1) AND batch = '' AND deadline IS NULL), (SELECT "
      "created FROM jobs WHERE state = 0 ORDER BY created LIMIT 1)");
  if (!row.next()) return;
  counts.unawaited = static_cast<std::uint64_t>(row.number(0));
  counts.oldest_queued = row.time_if_any(1);
}

struct GivenUp {
  std::uint64_t jobs = 0;
  std::vector<JobKey> to_tell;  // that are in no batch
};

GivenUp give_up_waiting(PgConnection& connection, Moment moment) {
  PgRows row = connection.query(
      "WITH mine AS MATERIALIZED (SELECT number FROM jobs WHERE state = 0 AND expires_if_never_run <= $1 ORDER BY "
      "owner, id LIMIT $3 FOR NO KEY UPDATE SKIP LOCKED) "
      "UPDATE jobs SET state = 3, finished = $1, expires = $2, last_error = CASE last_error WHEN '' THEN "
      "'nobody ran it in time' ELSE last_error END FROM mine WHERE jobs.number = mine.number RETURNING owner, id, "
      "batch",
      moment.now, moment.keep_until, kPortion);
  GivenUp given_up;
  while (row.next()) {
    ++given_up.jobs;
    if (row.bytes(2).empty()) given_up.to_tell.push_back({row.text(0), row.text(1)});
  }
  return given_up;
}

std::uint64_t remove_expired(PgConnection& connection, TimePoint now, std::int64_t most) {
  return connection
      .query(MESHGAUGE_PG_REMOVE "expires <= $1 AND " MESHGAUGE_PG_IN_NO_BATCH " LIMIT $2" MESHGAUGE_PG_UNLOCKED, now,
             most)
      .changed();
}

std::vector<Kept> kept_jobs(PgConnection& connection) {
  PgRows row = connection.query("SELECT owner, count(*) FROM jobs WHERE state >= 2 GROUP BY owner");
  std::vector<Kept> kept;
  while (row.next()) kept.push_back({row.text(0), static_cast<std::uint64_t>(row.number(1))});
  return kept;
}

// Those that were given to record() come first: their clients have had their answers.
std::uint64_t remove_oldest(PgConnection& connection, const std::string& owner, std::uint64_t wanted) {
  const std::uint64_t records =
      connection
          .query(MESHGAUGE_PG_REMOVE
                 "owner = $1 AND worker = '' AND tries = 1 ORDER BY finished, number LIMIT $2" MESHGAUGE_PG_UNLOCKED,
                 owner, wanted)
          .changed();
  if (records == wanted) return records;
  return records + connection
                       .query(MESHGAUGE_PG_REMOVE "owner = $1 ORDER BY finished, number LIMIT $2" MESHGAUGE_PG_UNLOCKED,
                              owner, wanted - records)
                       .changed();
}

std::uint64_t remove_over_share(PgConnection& connection, std::uint64_t max_kept, std::int64_t most) {
  return remove_over_share(
      kept_jobs(connection), max_kept, static_cast<std::uint64_t>(most),
      [&](const std::string& owner, std::uint64_t wanted) { return remove_oldest(connection, owner, wanted); });
}

}  // namespace

Result<bool> PostgresStore::forget(const JobKey& key) {
  if (behind_.find(key)) {
    Result<Done> flushed = flush();
    if (!flushed) return flushed.error();
  }
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    return connection.query(MESHGAUGE_PG_REMOVE "owner = $1 AND id = $2" MESHGAUGE_PG_UNLOCKED, key.owner, key.id)
               .changed() == 1;
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
    auto lost = lost_jobs(connection.query(kOfToken, token.key.owner, token.key.id, token.worker, token.tries));
    for (Lost& job : lost) job.after = after_hand_back(job.loss, last_error.empty());
    store::hand_back(connection, lost, last_error, moment);
    transaction.commit();
    return lost;
  });
  if (!back) return back.error();
  if (back->empty()) return std::optional<JobState>();
  const Lost& job = back->front();
  tell_handed_back(job.key, job.after.state, job.loss.in_batch);
  return std::optional(job.after.state);
}

Result<std::vector<Job>> PostgresStore::recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                                Moment moment) {
  const auto lost = pool_.run(
      Promise::durable, [&](PgConnection& connection) { return hand_back_dead(connection, dead_workers, why, moment); },
      kLonger);
  if (!lost) return lost.error();
  for (const Lost& job : *lost) tell_handed_back(job.key, job.after.state, job.loss.in_batch);
  if (const Result<Done> rest = cancel_the_rest(moment); !rest) return rest.error();
  return std::vector<Job>();
}

Result<Counts> PostgresStore::counts() {
  Result<Counts> counts = pool_.run(Promise::fleeting, [](PgConnection& connection) {
    Counts counted;
    PgRows row = connection.query("SELECT state, count(*) FROM jobs GROUP BY state");
    while (row.next()) add(counted, static_cast<JobState>(row.number(0)), static_cast<std::uint64_t>(row.number(1)));
    add_waiting(connection, counted);
    return counted;
  });
  if (!counts) return counts;
  behind_.add_to(*counts);
  return counts;
}

Result<std::uint64_t> PostgresStore::unended(const std::string& owner, TimePoint now) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    // Both halves go by an index in which no batch is looked through.
    PgRows row = connection.query(
        "SELECT count(*) FROM (SELECT deadline, cancel_requested FROM jobs WHERE state = 0 AND owner = $1 AND batch = "
        "'' UNION ALL SELECT deadline, cancel_requested FROM jobs WHERE state = 1 AND owner = $1 AND batch = '') AS "
        "mine WHERE NOT cancel_requested AND (deadline IS NULL OR deadline > $2)",
        owner, now);
    return row.next() ? static_cast<std::uint64_t>(row.number(0)) : std::uint64_t{0};
  });
}

Result<std::vector<BlobKey>> PostgresStore::used_blobs() {
  return pool_.run(
      Promise::fleeting,
      [](PgConnection& connection) {
        PgRows row = connection.query(
            "SELECT owner, mesh_a FROM jobs WHERE state IN (0, 1) UNION SELECT owner, mesh_b FROM jobs WHERE state IN "
            "(0, 1) UNION SELECT owner, id FROM meshes");
        std::vector<BlobKey> keys;
        while (row.next()) keys.push_back({row.text(0), row.text(1)});
        return keys;
      },
      kLonger);
}

Result<bool> PostgresStore::uses_blob(const BlobKey& key) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(
        "SELECT 1 WHERE EXISTS (SELECT FROM meshes WHERE owner = $1 AND id = $2) OR EXISTS (SELECT FROM jobs WHERE "
        "state IN (0, 1) AND owner = $1 AND mesh_a = $2) OR EXISTS (SELECT FROM jobs WHERE state IN (0, 1) AND owner = "
        "$1 AND mesh_b = $2)",
        key.owner, key.id);
    return row.next();
  });
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
  const auto expired = remove_in_portions(
      [&](PgConnection& connection, std::int64_t most) { return remove_expired(connection, moment.now, most); });
  if (!expired) return expired.error();
  swept.expired = *expired;
  const auto over_cap = remove_in_portions(
      [&](PgConnection& connection, std::int64_t most) { return remove_over_share(connection, max_kept, most); });
  if (!over_cap) return over_cap.error();
  swept.over_cap = *over_cap;
  return swept;
}

}  // namespace meshgauge::server::store
