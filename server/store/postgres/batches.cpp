// PostgresStore: BatchStore.
//
// Calls that change which batches point at a job (insert_batch(), cancel_batch(), forget_batch(), sweep_batches()) take
// a lock of the owner first. So no job is cancelled or removed while another batch begins to point at it.
#include <algorithm>
#include <thread>
#include <unordered_map>

#include "server/store/postgres/postgres_store.h"
#include "server/store/rows.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kOwnersBatches = 0x4d474a33;  // a lock; schema.cpp and control.cpp have others

void lock_batches_of(PgConnection& connection, const std::string& owner) {
  connection.query("SELECT pg_advisory_xact_lock($1::int, hashtext(encode($2, 'hex')))", kOwnersBatches, owner);
}

bool insert_head(PgConnection& connection, const NewBatch& batch) {
  return connection
             .query(R"sql(
    INSERT INTO batches (owner, id, name, idempotency_key, fingerprint, created)
    VALUES ($1, $2, $3, $4, $5, $6)
    ON CONFLICT DO NOTHING)sql",
                    batch.key.owner, batch.key.id, batch.name, none_if_empty(batch.idempotency_key), batch.fingerprint,
                    batch.created)
             .changed() == 1;
}

// Keeps the meshes until the end of the transaction: a process that then removes one finds the jobs that refer to it.
// false: one of them is not there.
bool lock_meshes(PgConnection& connection, const NewBatch& batch) {
  if (batch.meshes.empty()) return true;
  return batch.meshes.size() == only_count(connection.query(R"sql(
    SELECT count(*) FROM unnest($2::bytea[]) AS given (id)
    CROSS JOIN LATERAL (
      SELECT 1 FROM meshes WHERE owner = $1 AND meshes.id = given.id FOR KEY SHARE) AS found)sql",
                                                            batch.key.owner, batch.meshes));
}

using JobsByWork = std::unordered_map<std::string, std::string>;

// Returns the jobs that do the work of some items already, locked until these items point at them.
JobsByWork find_work(PgConnection& connection, const NewBatch& batch) {
  std::vector<std::string> works;
  for (const BatchItem& item : batch.items) {
    if (!item.work.empty()) works.push_back(item.work);
  }
  std::sort(works.begin(), works.end());
  works.erase(std::unique(works.begin(), works.end()), works.end());
  if (works.empty()) return {};
  PgRows row = connection.query(R"sql(
    SELECT given.work, found.id FROM unnest($2::bytea[]) AS given (work)
    CROSS JOIN LATERAL (
      SELECT id FROM jobs
      WHERE owner = $1 AND work = given.work AND work <> ''
        AND ((state < 2 AND NOT cancel_requested) OR (state = 2 AND reusable))
      ORDER BY state DESC, number LIMIT 1
      FOR KEY SHARE) AS found)sql",
                                batch.key.owner, works);
  JobsByWork jobs;
  while (row.next()) jobs.emplace(row.text(0), row.text(1));
  return jobs;
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
    rows.push_back({as_queued(item.job), item.work});
    if (!item.work.empty()) known.emplace(item.work, item.job.key.id);
  }
  if (!rows.empty() && insert_rows(connection, rows) != rows.size()) {
    throw PgFailure{"23505", "a job of a batch has the id of another job", false, false};
  }
  connection.query(R"sql(
    INSERT INTO batch_items (owner, batch, position, name, job)
    SELECT $1, $2, place - 1, name, job
    FROM unnest($3::bytea[], $4::bytea[]) WITH ORDINALITY AS item (name, job, place))sql",
                   batch.key.owner, batch.key.id, names, jobs);
}

InsertedBatch insert(PgConnection& connection, const NewBatch& batch) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, batch.key.owner);
  if (batch.repeats || !insert_head(connection, batch)) {
    auto there = existing_batch(connection, batch);
    if (!there && batch.repeats) return {{}, false, false, false, true};
    if (!there) throw PgFailure{"40001", "a batch was removed while it was read", false, true};
    connection.put_barrier();
    transaction.commit();
    return *std::move(there);
  }
  if (!lock_meshes(connection, batch)) return {{}, false, false, true};
  insert_items(connection, batch);
  InsertedBatch inserted{find_batch(connection, batch.key)->batch, false, false, false};
  transaction.commit();
  return inserted;
}

// The jobs of a batch's items (those of `items`, a condition on `mine`) at which no other batch points; a batch `its`
// counts as another only where `others` holds.
template <std::size_t kItems, std::size_t kOthers>
constexpr auto own_jobs(const Sql<kItems>& items, const Sql<kOthers>& others) {
  return R"sql(own AS MATERIALIZED (
      SELECT DISTINCT job FROM batch_items AS mine
      WHERE mine.owner = $1 AND mine.batch = $2)sql" +
         items + R"sql(
        AND NOT EXISTS (
          SELECT FROM batch_items AS other JOIN batches AS its ON its.owner = other.owner AND its.id = other.batch
          WHERE other.owner = mine.owner AND other.job = mine.job AND other.batch <> mine.batch)sql" +
         others + R"sql(
          OFFSET 0)))sql";
}
constexpr Sql kStillWanted(" AND NOT its.cancel_requested");

// Jobs `own` that the cancelled batch still has to end, or whose workers are still to be told.
constexpr Sql kToCancel(R"sql(jobs.owner = $1 AND jobs.id = own.job AND batch <> ''
          AND (state + 0 = 0 OR (state + 0 = 1 AND NOT cancel_requested)))sql");

constexpr auto kCancelItems = "WITH " + own_jobs(Sql(" AND mine.position >= $5 AND mine.position < $6"), kStillWanted) +
                              R"sql(,
    those AS MATERIALIZED (
      SELECT found.number FROM (SELECT job FROM own ORDER BY job) AS own
      CROSS JOIN LATERAL (SELECT number FROM jobs WHERE )sql" +
                              kToCancel + R"sql( FOR UPDATE SKIP LOCKED) AS found)
    UPDATE jobs SET)sql" + kCancel +
                              R"sql(
    FROM those WHERE jobs.number = those.number
    RETURNING jobs.id, jobs.state)sql";
constexpr auto kLeftToCancel = "WITH " + own_jobs(Sql(""), kStillWanted) + R"sql(
    SELECT 1 FROM own CROSS JOIN LATERAL (SELECT 1 FROM jobs WHERE )sql" +
                               kToCancel + " OFFSET 0) AS found LIMIT 1";
constexpr auto kRemoveOwnJobs = "WITH " + own_jobs(Sql(""), Sql("")) + R"sql(
    DELETE FROM jobs
    WHERE number = ANY (ARRAY(
      SELECT found.number FROM (SELECT job FROM own ORDER BY job) AS own
      CROSS JOIN LATERAL (
        SELECT number FROM jobs
        WHERE jobs.owner = $1 AND jobs.id = own.job AND jobs.batch <> '' AND state + 0 >= 2 FOR UPDATE) AS found)))sql";

// A job of the batch `its` has not ended, or not before $1 (NULL: whenever it ended).
constexpr Sql kHasNotEnded(R"sql(EXISTS (
        SELECT FROM batch_items AS item
        CROSS JOIN LATERAL (
          SELECT 1 FROM jobs WHERE owner = item.owner AND id = item.job AND (state < 2 OR finished >= $1)
          OFFSET 0) AS found
        WHERE item.owner = its.owner AND item.batch = its.id OFFSET 0))sql");
constexpr auto kLockEnded =
    "SELECT 1 FROM batches AS its WHERE owner = $2 AND id = $3 AND NOT " + kHasNotEnded + " FOR UPDATE";
constexpr auto kEndedBefore = "SELECT owner, id FROM batches AS its WHERE created < $1 AND NOT " + kHasNotEnded;

constexpr std::uint64_t kItemPortion = 250;             // items whose jobs one transaction cancels
constexpr auto kPause = std::chrono::milliseconds(20);  // before jobs that others had locked are tried again

// Returns the number of items; 0: there is no such batch. From now on recover() finishes what this process does not.
std::uint64_t mark_cancelled(PgConnection& connection, const JobKey& key) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, key.owner);
  const std::uint64_t items = only_count(connection.query(R"sql(
    UPDATE batches SET cancel_requested = true WHERE owner = $1 AND id = $2
    RETURNING (SELECT coalesce(max(position) + 1, 0) FROM batch_items WHERE owner = $1 AND batch = $2))sql",
                                                          key.owner, key.id));
  transaction.commit();
  return items;
}

// Cancels the jobs of the items from this position on; returns those that run. Skips locked jobs, which the next round
// tries again: so calls that end or renew jobs wait for one portion at most, and this one does not wait for them.
std::vector<JobKey> cancel_portion(PgConnection& connection, const JobKey& key, std::uint64_t from, Moment moment) {
  PgTransaction transaction(connection);
  lock_batches_of(connection, key.owner);
  PgRows row =
      connection.query(kCancelItems, key.owner, key.id, moment.now, moment.keep_until, from, from + kItemPortion);
  std::vector<JobKey> running;
  while (row.next()) {
    if (static_cast<JobState>(row.number(1)) == JobState::running) running.push_back({key.owner, row.text(0)});
  }
  transaction.commit();
  return running;
}

// Batches that another process left half cancelled. Such a job belongs to the cancelled batch that made it, so these
// are found by what is queued or runs.
std::vector<JobKey> half_cancelled(PgConnection& connection) {
  return keys_of<JobKey>(connection.query(R"sql(
    SELECT owner, id FROM batches AS its
    WHERE cancel_requested
      AND (EXISTS (SELECT FROM jobs WHERE state = 0 AND owner = its.owner AND batch = its.id OFFSET 0)
           OR EXISTS (SELECT FROM jobs
                      WHERE state = 1 AND NOT cancel_requested AND owner = its.owner AND batch = its.id
                      OFFSET 0)))sql"));
}

// false: there is no such batch, or not all of its jobs have ended, before `ended_before` if that is given.
// Precondition: a transaction is open.
bool remove_batch(PgConnection& connection, const JobKey& key, std::optional<TimePoint> ended_before) {
  lock_batches_of(connection, key.owner);
  if (!connection.query(kLockEnded, ended_before, key.owner, key.id).next()) return false;
  connection.query(kRemoveOwnJobs, key.owner, key.id);
  connection.query("DELETE FROM batch_items WHERE owner = $1 AND batch = $2", key.owner, key.id);
  connection.query("DELETE FROM batches WHERE owner = $1 AND id = $2", key.owner, key.id);
  return true;
}

}  // namespace

Result<InsertedBatch> PostgresStore::insert_batch(const NewBatch& batch) {
  Result<InsertedBatch> inserted = pool_.run(
      Promise::durable, [&](PgConnection& connection) { return store::insert(connection, batch); }, kLonger);
  if (inserted && !inserted->existed && !inserted->mesh_gone && !inserted->gone) control_.tell(Signal::Kind::work);
  return inserted;
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
    const Result<bool> left = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
      return connection.query(kLeftToCancel, key.owner, key.id).next();
    });
    if (!left) return left.error();
    if (!*left || std::chrono::steady_clock::now() >= until) break;  // recover() finishes the rest
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

Result<bool> PostgresStore::forget_batch(const JobKey& key) {
  bool removed = false;  // also by a try whose commit was not acknowledged
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
      Promise::fleeting,
      [&](PgConnection& connection) { return keys_of<JobKey>(connection.query(kEndedBefore, ended_before)); }, kLonger);
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
