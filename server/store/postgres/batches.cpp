// PostgresStore: BatchStore.
//
// Whatever changes which batches point at a job (insert_batch(), cancel_batch(), forget_batch(), sweep_batches()) takes
// a lock of the owner first, so that no job is cancelled or removed while another batch begins to point at it.
#include <algorithm>
#include <thread>
#include <unordered_map>

#include "server/store/postgres/job_rows.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {
namespace {

constexpr int kLonger = 5;                           // of the call_timeout, for ten thousand rows
constexpr std::int64_t kOwnersBatches = 0x4d474a33;  // a lock beside those of schema.cpp and control.cpp

void lock_batches_of(PgConnection& connection, const std::string& owner) {
  connection.query("SELECT pg_advisory_xact_lock($1::int, hashtext(encode($2, 'hex')))", kOwnersBatches, owner);
}

std::optional<Batch> find_batch(PgConnection& connection, const JobKey& key) {
  PgRows row = connection.query(
      "SELECT batch.name, batch.created, batch.cancel_requested, count(item.position), count(*) FILTER (WHERE state = "
      "0), count(*) FILTER (WHERE state = 1), count(*) FILTER (WHERE state = 2), count(*) FILTER (WHERE state = 3), "
      "count(*) FILTER (WHERE state = 4), count(*) FILTER (WHERE state = 2 AND verdict = 'pass'), count(*) FILTER "
      "(WHERE state = 2 AND verdict = 'fail'), count(*) FILTER (WHERE state = 2 AND verdict = 'undecided'), "
      "max(jobs.finished), max(jobs.expires) FROM batches AS batch LEFT JOIN batch_items AS item ON item.owner = "
      "batch.owner AND item.batch = batch.id LEFT JOIN LATERAL (SELECT state, verdict, finished, expires FROM jobs "
      "WHERE "
      "owner = item.owner AND id = item.job OFFSET 0) AS jobs ON true WHERE batch.owner = $1 AND batch.id = $2 GROUP "
      "BY "
      "batch.owner, batch.id",
      key.owner, key.id);
  if (!row.next()) return std::nullopt;
  const auto count = [&](int column) { return static_cast<std::uint64_t>(row.number(column)); };
  Batch batch{key, row.text(0), row.time(1), row.number(2) != 0, std::nullopt, std::nullopt, {}};
  batch.counts = {count(3), count(4), count(5), count(6), count(7), count(8), 0, count(9), count(10), count(11)};
  BatchCounts& counts = batch.counts;
  counts.gone = counts.total - counts.queued - counts.running - counts.done - counts.failed - counts.cancelled;
  if (counts.queued + counts.running > 0) return batch;
  // It has not ended before it was made, even if all its work was done before.
  batch.finished = std::max(batch.created, row.time_if_any(12).value_or(batch.created));
  batch.expires = std::max(*batch.finished, row.time_if_any(13).value_or(*batch.finished));
  return batch;
}

std::optional<JobKey> find_idempotent_key(PgConnection& connection, const std::string& owner,
                                          const std::string& idempotency_key) {
  PgRows row =
      connection.query("SELECT id FROM batches WHERE owner = $1 AND idempotency_key = $2", owner, idempotency_key);
  if (!row.next()) return std::nullopt;
  return JobKey{owner, row.text(0)};
}

std::optional<InsertedBatch> existing(PgConnection& connection, const NewBatch& wanted) {
  std::optional<Batch> there = find_batch(connection, wanted.key);
  if (!there && !wanted.idempotency_key.empty()) {
    const auto key = find_idempotent_key(connection, wanted.key.owner, wanted.idempotency_key);
    if (key) there = find_batch(connection, *key);
  }
  if (!there) return std::nullopt;
  PgRows row =
      connection.query("SELECT fingerprint FROM batches WHERE owner = $1 AND id = $2", there->key.owner, there->key.id);
  const bool conflict = row.next() && row.text(0) != wanted.fingerprint;
  connection.put_barrier();
  return InsertedBatch{*std::move(there), true, conflict, false};
}

bool insert_head(PgConnection& connection, const NewBatch& batch) {
  const std::optional<std::string> idempotency_key =
      batch.idempotency_key.empty() ? std::nullopt : std::optional(batch.idempotency_key);
  return connection
             .query(
                 "INSERT INTO batches (owner, id, name, idempotency_key, fingerprint, created) VALUES ($1, $2, $3, "
                 "$4, $5, $6) ON CONFLICT DO NOTHING",
                 batch.key.owner, batch.key.id, batch.name, idempotency_key, batch.fingerprint, batch.created)
             .changed() == 1;
}

// They stay until the end of the transaction: whoever removes one then finds the jobs that refer to it.
bool lock_meshes(PgConnection& connection, const NewBatch& batch) {
  if (batch.meshes.empty()) return true;
  PgRows row = connection.query(
      "SELECT count(*) FROM unnest($2::bytea[]) AS given (id) CROSS JOIN LATERAL (SELECT 1 FROM meshes WHERE owner = "
      "$1 AND meshes.id = given.id FOR KEY SHARE) AS found",
      batch.key.owner, batch.meshes);
  return row.next() && static_cast<std::uint64_t>(row.number(0)) == batch.meshes.size();
}

using JobsByWork = std::unordered_map<std::string, std::string>;

// The jobs that do the work of some items already. A lock keeps them until these items point at them.
JobsByWork find_work(PgConnection& connection, const NewBatch& batch) {
  std::vector<std::string> works;
  for (const BatchItem& item : batch.items) {
    if (!item.work.empty()) works.push_back(item.work);
  }
  std::sort(works.begin(), works.end());
  works.erase(std::unique(works.begin(), works.end()), works.end());
  if (works.empty()) return {};
  PgRows row = connection.query(
      "SELECT given.work, found.id FROM unnest($2::bytea[]) AS given (work) CROSS JOIN LATERAL (SELECT id FROM jobs "
      "WHERE owner = $1 AND work = given.work AND work <> '' AND ((state < 2 AND NOT cancel_requested) OR (state = 2 "
      "AND reusable)) ORDER BY state DESC, number LIMIT 1 FOR KEY SHARE) AS found",
      batch.key.owner, works);
  JobsByWork jobs;
  while (row.next()) jobs.emplace(row.text(0), row.text(1));
  return jobs;
}

Job queued_job(const NewBatch& batch, const NewJob& asked) {
  Job job;
  static_cast<NewJob&>(job) = asked;
  job.key.owner = batch.key.owner;
  job.batch = batch.key.id;
  return job;
}

void insert_items(PgConnection& connection, const NewBatch& batch) {
  JobsByWork known = find_work(connection, batch);
  std::vector<JobRow> rows;
  std::vector<std::string> names, jobs;
  for (const BatchItem& item : batch.items) {
    const auto found = item.work.empty() ? known.end() : known.find(item.work);
    names.push_back(item.name);
    jobs.push_back(found == known.end() ? item.job.key.id : found->second);
    if (found != known.end()) continue;
    rows.push_back({queued_job(batch, item.job), item.work});
    if (!item.work.empty()) known.emplace(item.work, item.job.key.id);
  }
  if (!rows.empty() && insert_rows(connection, rows) != rows.size()) {
    throw PgFailure{"23505", "a job of a batch has the id of another job", false, false};
  }
  connection.query(
      "INSERT INTO batch_items (owner, batch, position, name, job) SELECT $1, $2, place - 1, name, job FROM "
      "unnest($3::bytea[], $4::bytea[]) WITH ORDINALITY AS item (name, job, place)",
      batch.key.owner, batch.key.id, names, jobs);
}

InsertedBatch insert(PgConnection& connection, const NewBatch& batch) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, batch.key.owner);
  if (batch.repeats || !insert_head(connection, batch)) {
    auto there = existing(connection, batch);
    if (!there && batch.repeats) return {{}, false, false, false, true};
    if (!there) throw PgFailure{"40001", "a batch went while it was looked at", false, true};
    transaction.commit();  // for the barrier
    return *std::move(there);
  }
  if (!lock_meshes(connection, batch)) return {{}, false, false, true};
  insert_items(connection, batch);
  InsertedBatch inserted{*find_batch(connection, batch.key), false, false, false};
  transaction.commit();
  return inserted;
}

// Jobs that nobody asked for by themselves, and that of all batches point only at this one, or at others of which
// OTHERS is not true. OFFSET 0, here and below, makes PostgreSQL find rows one by one in the index of their keys,
// whatever it believes of how many there are.
#define MESHGAUGE_PG_OWN_JOBS(ITEMS, OTHERS)                                                                          \
  "own AS MATERIALIZED (SELECT DISTINCT job FROM batch_items AS mine WHERE mine.owner = $1 AND mine.batch = $2" ITEMS \
  " AND NOT EXISTS (SELECT FROM batch_items AS other JOIN batches AS its ON its.owner = other.owner AND its.id = "    \
  "other.batch WHERE other.owner = mine.owner AND other.job = mine.job AND other.batch <> mine.batch" OTHERS          \
  " OFFSET 0)) "

#define MESHGAUGE_PG_STILL_WANTED " AND NOT its.cancel_requested"

// Of jobs: what a cancelled batch has to end, or to tell that it is to end.
#define MESHGAUGE_PG_TO_CANCEL "batch <> '' AND (state + 0 = 0 OR (state + 0 = 1 AND NOT cancel_requested)) "

constexpr std::uint64_t kItemPortion = 250;             // items whose jobs one transaction cancels
constexpr auto kPause = std::chrono::milliseconds(20);  // before those that somebody had locked are tried again

// 0: there is no such batch. It is promised from now on: whoever is on duty cancels what this process does not come to.
std::uint64_t mark_cancelled(PgConnection& connection, const JobKey& key) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, key.owner);
  PgRows row = connection.query(
      "UPDATE batches SET cancel_requested = true WHERE owner = $1 AND id = $2 RETURNING (SELECT "
      "coalesce(max(position) + 1, 0) FROM batch_items WHERE owner = $1 AND batch = $2)",
      key.owner, key.id);
  const std::uint64_t items = row.next() ? static_cast<std::uint64_t>(row.number(0)) : 0;
  transaction.commit();
  return items;
}

// Of the items from this position on. What another has locked is left to the next look: so nobody who ends or renews
// jobs waits for more than a portion, nor this for them.
std::vector<JobKey> cancel_portion(PgConnection& connection, const JobKey& key, std::uint64_t from, Moment moment) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, key.owner);
  PgRows row = connection.query(
      "WITH " MESHGAUGE_PG_OWN_JOBS(" AND mine.position >= $5 AND mine.position < $6", MESHGAUGE_PG_STILL_WANTED)
      ", those AS MATERIALIZED (SELECT found.number FROM (SELECT job FROM own ORDER BY job) AS own CROSS JOIN LATERAL "
      "(SELECT number FROM jobs WHERE jobs.owner = $1 AND jobs.id = own.job AND " MESHGAUGE_PG_TO_CANCEL
      "FOR UPDATE SKIP LOCKED) AS found) "
      "UPDATE jobs SET cancel_requested = true, state = CASE state WHEN 0 THEN 4 ELSE 1 END, finished = CASE state "
      "WHEN 0 THEN $3 END, expires = CASE state WHEN 0 THEN $4 END FROM those WHERE jobs.number = those.number "
      "RETURNING jobs.id, jobs.state",
      key.owner, key.id, moment.now, moment.keep_until, from, from + kItemPortion);
  std::vector<JobKey> running;
  while (row.next()) {
    if (static_cast<JobState>(row.number(1)) == JobState::running) running.push_back({key.owner, row.text(0)});
  }
  transaction.commit();
  return running;
}

bool is_left_to_cancel(PgConnection& connection, const JobKey& key) {
  PgRows row = connection.query(
      "WITH " MESHGAUGE_PG_OWN_JOBS("", MESHGAUGE_PG_STILL_WANTED)
      "SELECT 1 FROM own CROSS JOIN LATERAL (SELECT 1 FROM jobs WHERE jobs.owner = $1 AND jobs.id = own.job "
      "AND " MESHGAUGE_PG_TO_CANCEL "OFFSET 0) AS found LIMIT 1",
      key.owner, key.id);
  return row.next();
}

// Whoever cancelled them may have died over it. Each such job is still in a batch that was cancelled and made it, so
// these are found by what waits or runs.
std::vector<JobKey> half_cancelled(PgConnection& connection) {
  PgRows row = connection.query(
      "SELECT owner, id FROM batches AS its WHERE cancel_requested AND (EXISTS (SELECT FROM jobs WHERE state = 0 AND "
      "owner = its.owner AND batch = its.id OFFSET 0) OR EXISTS (SELECT FROM jobs WHERE state = 1 AND "
      "NOT cancel_requested AND owner = its.owner AND batch = its.id OFFSET 0))");
  std::vector<JobKey> keys;
  while (row.next()) keys.push_back({row.text(0), row.text(1)});
  return keys;
}

// In a transaction. false: there is none, or not all of its jobs have ended, the last one before `ended_before` if that
// is given.
bool remove_batch(PgConnection& connection, const JobKey& key, std::optional<TimePoint> ended_before) {
  lock_batches_of(connection, key.owner);
  PgRows row = connection.query(
      "SELECT 1 FROM batches WHERE owner = $1 AND id = $2 AND NOT EXISTS (SELECT FROM batch_items AS item CROSS JOIN "
      "LATERAL (SELECT 1 FROM jobs WHERE owner = $1 AND id = item.job AND (state < 2 OR finished >= $3) OFFSET 0) AS "
      "found WHERE item.owner = $1 AND item.batch = $2) FOR UPDATE",
      key.owner, key.id, ended_before);
  if (!row.next()) return false;
  connection.query(
      "WITH " MESHGAUGE_PG_OWN_JOBS("", "")
      " DELETE FROM jobs WHERE number = ANY (ARRAY(SELECT found.number FROM (SELECT job FROM own ORDER BY job) AS own "
      "CROSS JOIN LATERAL (SELECT number FROM jobs WHERE jobs.owner = $1 AND jobs.id = own.job AND jobs.batch <> '' AND "
      "state + 0 >= 2 FOR UPDATE) AS found))",
      key.owner, key.id);
  connection.query("DELETE FROM batch_items WHERE owner = $1 AND batch = $2", key.owner, key.id);
  connection.query("DELETE FROM batches WHERE owner = $1 AND id = $2", key.owner, key.id);
  return true;
}

std::vector<JobKey> batches_before(PgConnection& connection, TimePoint ended_before) {
  PgRows row = connection.query(
      "SELECT owner, id FROM batches AS batch WHERE created < $1 AND NOT EXISTS (SELECT FROM batch_items AS item CROSS "
      "JOIN LATERAL (SELECT 1 FROM jobs WHERE owner = item.owner AND id = item.job AND (state < 2 OR finished >= $1) "
      "OFFSET 0) AS found WHERE item.owner = batch.owner AND item.batch = batch.id OFFSET 0)",
      ended_before);
  std::vector<JobKey> keys;
  while (row.next()) keys.push_back({row.text(0), row.text(1)});
  return keys;
}

#define MESHGAUGE_PG_ROWS                                                                                             \
  "SELECT " MESHGAUGE_PG_JOB                                                                                          \
  ", position, item_name FROM (SELECT item.position, item.name AS item_name, jobs.* FROM batch_items AS item "        \
  "LEFT JOIN LATERAL (SELECT * FROM jobs WHERE owner = item.owner AND id = item.job OFFSET 0) AS jobs ON true WHERE " \
  "item.owner = $1 AND item.batch = $2 "

constexpr const char* kEnded = MESHGAUGE_PG_ROWS
    "AND item.position >= $3 AND (state >= 2 OR state IS NULL) ORDER BY item.position LIMIT $4) AS item ORDER BY "
    "position";

#define MESHGAUGE_PG_BADNESS                                                                                        \
  "CASE WHEN state = 3 THEN 2 WHEN state = 4 THEN 4 WHEN state = 2 AND verdict = 'fail' THEN 1 WHEN state = 2 AND " \
  "verdict = 'undecided' THEN 3 END"

constexpr const char* kFailuresFirst =
    MESHGAUGE_PG_ROWS "AND item.position >= $3 AND " MESHGAUGE_PG_BADNESS " IS NOT NULL ORDER BY " MESHGAUGE_PG_BADNESS
                      ", item.position LIMIT $4) AS item ORDER BY " MESHGAUGE_PG_BADNESS ", position";

}  // namespace

Result<InsertedBatch> PostgresStore::insert_batch(const NewBatch& batch) {
  Result<InsertedBatch> inserted = pool_.run(
      Promise::durable, [&](PgConnection& connection) { return store::insert(connection, batch); }, kLonger);
  if (inserted && !inserted->existed && !inserted->mesh_gone && !inserted->gone) control_.tell(Signal::Kind::work);
  return inserted;
}

Result<std::optional<Batch>> PostgresStore::get_batch(const JobKey& key) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find_batch(connection, key); });
}

Result<std::optional<Batch>> PostgresStore::find_idempotent_batch(const std::string& owner,
                                                                  const std::string& idempotency_key) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) -> std::optional<Batch> {
    const auto key = find_idempotent_key(connection, owner, idempotency_key);
    return key ? find_batch(connection, *key) : std::nullopt;
  });
}

Result<std::vector<BatchRow>> PostgresStore::batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                                        std::size_t most) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(which == Rows::ended ? kEnded : kFailuresFirst, key.owner, key.id, from, most);
    constexpr int kPosition = kPgJobColumns;  // after those of the job
    std::vector<BatchRow> rows;
    while (row.next()) {
      const auto position = static_cast<std::uint64_t>(row.number(kPosition));
      rows.push_back({position, row.text(kPosition + 1), std::nullopt});
      if (!row.is_null(1)) rows.back().job = pg_job_of(row);
    }
    return rows;
  });
}

Result<Done> PostgresStore::cancel_jobs_of(const JobKey& key, std::uint64_t items, Moment moment) {
  for (std::uint64_t from = 0; from < items; from += kItemPortion) {
    const Result<std::vector<JobKey>> running = pool_.run(
        Promise::durable, [&](PgConnection& connection) { return cancel_portion(connection, key, from, moment); });
    if (!running) return running.error();
    for (const JobKey& job : *running) control_.tell(Signal::Kind::cancel, job);
  }
  return Done{};
}

Result<bool> PostgresStore::cancel_batch(const JobKey& key, Moment moment) {
  const auto until = std::chrono::steady_clock::now() + kLonger * pool_.settings().call_timeout;
  const Result<std::uint64_t> items =
      pool_.run(Promise::durable, [&](PgConnection& connection) { return mark_cancelled(connection, key); });
  if (!items) return items.error();
  while (*items > 0) {
    const Result<bool> left =
        pool_.run(Promise::fleeting, [&](PgConnection& connection) { return is_left_to_cancel(connection, key); });
    if (!left) return left.error();
    if (!*left || std::chrono::steady_clock::now() >= until) break;  // what is left is for who is on duty
    if (const Result<Done> cancelled = cancel_jobs_of(key, *items, moment); !cancelled) return cancelled.error();
    std::this_thread::sleep_for(kPause);
  }
  return *items > 0;
}

Result<Done> PostgresStore::cancel_the_rest(Moment moment) {
  const Result<std::vector<JobKey>> keys = pool_.run(Promise::fleeting, half_cancelled);
  if (!keys) return keys.error();
  for (const JobKey& key : *keys) {
    if (const Result<bool> cancelled = cancel_batch(key, moment); !cancelled) return cancelled.error();
  }
  return Done{};
}

Result<BatchStore::Load> PostgresStore::batch_load(const std::string& owner) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(
        "SELECT coalesce(sum(jobs), 0)::int8, count(*) FROM (SELECT batch, count(*) AS jobs FROM jobs WHERE state "
        "IN (0, 1) AND owner = $1 AND batch <> '' GROUP BY batch) AS mine",
        owner);
    row.next();
    return Load{static_cast<std::uint64_t>(row.number(0)), static_cast<std::uint64_t>(row.number(1))};
  });
}

Result<bool> PostgresStore::forget_batch(const JobKey& key) {
  bool removed = false;  // also by a try whose commit was not heard of
  return pool_.run(
      Promise::durable,
      [&](PgConnection& connection) {
        PgTransaction transaction(connection);
        removed |= remove_batch(connection, key, std::nullopt);
        transaction.commit();
        return removed;
      },
      kLonger);
}

Result<std::uint64_t> PostgresStore::sweep_batches(TimePoint ended_before) {
  const Result<std::vector<JobKey>> over = pool_.run(
      Promise::fleeting, [&](PgConnection& connection) { return batches_before(connection, ended_before); }, kLonger);
  if (!over) return over.error();
  std::uint64_t removed = 0;
  for (const JobKey& key : *over) {
    const Result<bool> gone = pool_.run(
        Promise::durable,
        [&](PgConnection& connection) {
          PgTransaction transaction(connection);
          const bool was_there = remove_batch(connection, key, ended_before);
          transaction.commit();
          return was_there;
        },
        kLonger);
    if (!gone) return gone.error();
    if (*gone) ++removed;
  }
  return removed;
}

}  // namespace meshgauge::server::store
