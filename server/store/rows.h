// Rows of either database as the structs of the store's interfaces, and the questions that both answer by the same
// statement. A Row is a Query (SQLite) or PgRows (PostgreSQL), a Db the connection that it comes from.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/store/batch_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/policy.h"
#include "server/store/sql.h"

namespace meshgauge::server::store {

template <class Row>
std::uint64_t count_in(const Row& row, int column) {
  return static_cast<std::uint64_t>(row.number(column));
}

// The number that a statement of one row and one column returns.
template <class Row>
std::uint64_t only_count(Row&& row) {
  return row.next() ? count_in(row, 0) : 0;
}

// A text for a column in which "" is NULL.
inline std::optional<std::string> none_if_empty(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional(text);
}

// A value of the progress for a column that is NULL without one.
template <class Value>
std::optional<Value> told(const std::optional<Progress>& progress, Value Progress::*member) {
  return progress ? std::optional((*progress).*member) : std::nullopt;
}

// --- Jobs ---

inline constexpr Sql kJobColumns(R"sql(
  owner, id, state, mesh_a, mesh_b, hints, options, cost, idempotency_key, fingerprint, trace, created,
  expires_if_never_run, tries, worker, cancel_requested, started, finished, expires, lower, upper, stage, document,
  problem, last_error, batch, deadline, verdict, excused, bounds_by, client)sql");
inline constexpr int kJobColumnCount = 31;
// What an inserted row names; the others have their defaults.
inline constexpr Sql kInsertedColumns(R"sql(
      owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, fingerprint, trace, created,
      expires_if_never_run, batch, deadline, tries, cancel_requested, started, finished, expires, lower, upper, stage,
      document, problem, last_error, verdict, work, bounds_by, client)sql");

inline constexpr auto kFindJob = "SELECT" + kJobColumns + " FROM jobs WHERE owner = $1 AND id = $2";
inline constexpr auto kFindIdempotentJob =
    "SELECT" + kJobColumns + " FROM jobs WHERE owner = $1 AND idempotency_key = $2";

template <class Row>
Job job_of(const Row& row) {
  Job job;
  job.key = {row.text(0), row.text(1)};
  job.state = static_cast<JobState>(row.number(2));
  job.mesh_a = row.text(3);
  job.mesh_b = row.text(4);
  job.hints = row.text(5);
  job.options = row.text(6);
  job.cost = count_in(row, 7);
  job.idempotency_key = row.text(8);
  job.fingerprint = row.text(9);
  job.trace = row.text(10);
  job.created = row.time(11);
  job.expires_if_never_run = row.time(12);
  job.tries = static_cast<unsigned>(row.number(13));
  job.cancel_requested = row.number(15) != 0;
  job.started = row.time_if_any(16);
  job.finished = row.time_if_any(17);
  job.expires = row.time_if_any(18);
  if (!row.is_null(19)) job.progress = Progress{row.real(19), row.real(20), row.text(21), row.text(29)};
  job.document = row.text(22);
  job.problem = row.text(23);
  job.last_error = row.text(24);
  job.batch = row.text(25);
  job.deadline = row.time_if_any(26);
  job.verdict = row.text(27);
  job.client = row.text(30);
  const bool trying = job.state == JobState::running;
  job.suspected = job.tries > row.number(28) + (trying ? 1 : 0);
  return job;
}

template <class Row>
Claimed claimed_of(const Row& row) {
  return {{{row.text(0), row.text(1)}, row.text(14), static_cast<unsigned>(row.number(13))}, job_of(row)};
}

template <class Row>
std::optional<Job> first_job(Row&& row) {
  if (!row.next()) return std::nullopt;
  return job_of(row);
}

template <class Row>
std::vector<Job> jobs_of(Row&& row) {
  std::vector<Job> jobs;
  while (row.next()) jobs.push_back(job_of(row));
  return jobs;
}

// Returns the keys of rows whose first two columns are owner and id. Key is JobKey or BlobKey.
template <class Key, class Row>
std::vector<Key> keys_of(Row&& row) {
  std::vector<Key> keys;
  while (row.next()) keys.push_back({row.text(0), row.text(1)});
  return keys;
}

template <class Db>
Origin find_origin(Db& db) {
  auto&& row = db.query("SELECT born, doubted FROM origin");
  row.next();
  return {row.time(0), row.time_if_any(1)};
}

template <class Db>
std::optional<Job> find_job(Db& db, const JobKey& key) {
  return first_job(db.query(kFindJob, key.owner, key.id));
}

// A job for JobStore::check(), which removes it in the transaction that inserts it: no other call sees it. It has
// ended, so that it leaves nothing in the indexes that claims read.
inline Job trial_job(const std::string& id, TimePoint at) {
  Job job;
  job.key.id = id;
  job.state = JobState::done;
  job.created = job.expires_if_never_run = at;
  job.finished = job.expires = at;
  return job;
}

template <class Db>
std::optional<Job> find_idempotent_job(Db& db, const std::string& owner, const std::string& key) {
  return first_job(db.query(kFindIdempotentJob, owner, key));
}

// What JobStore::insert() returns of a job that is there already. nullopt: it has gone since.
template <class Db>
std::optional<Inserted> existing_job(Db& db, const NewJob& job) {
  std::optional<Job> there = find_job(db, job.key);
  if (!there && !job.idempotency_key.empty()) there = find_idempotent_job(db, job.key.owner, job.idempotency_key);
  if (!there) return std::nullopt;
  const bool conflict = there->fingerprint != job.fingerprint;
  return Inserted{*std::move(there), true, conflict};
}

inline Job as_queued(const NewJob& job) {
  Job queued;
  static_cast<NewJob&>(queued) = job;
  return queued;
}

template <class Db>
Counts count_jobs(Db& db) {
  Counts counts;
  std::uint64_t* const fields[] = {&counts.queued, &counts.running, &counts.done, &counts.failed, &counts.cancelled};
  auto row = db.query("SELECT state, count(*) FROM jobs GROUP BY state");
  while (row.next()) *fields[row.number(0)] = count_in(row, 1);
  auto waiting = db.query(R"sql(
    SELECT (SELECT count(*) FROM jobs WHERE state IN (0, 1) AND batch = '' AND deadline IS NULL),
      (SELECT created FROM jobs WHERE state = 0 ORDER BY created LIMIT 1))sql");
  if (!waiting.next()) return counts;
  counts.unawaited = count_in(waiting, 0);
  counts.oldest_queued = waiting.time_if_any(1);
  return counts;
}

// Both halves go by an index in which no batch is looked through.
template <class Db>
std::uint64_t count_unended(Db& db, const std::string& owner, TimePoint now) {
  return only_count(db.query(R"sql(
    SELECT count(*)
    FROM (SELECT deadline, cancel_requested FROM jobs WHERE state = 0 AND owner = $1 AND batch = ''
          UNION ALL
          SELECT deadline, cancel_requested FROM jobs WHERE state = 1 AND owner = $1 AND batch = '') AS mine
    WHERE NOT cancel_requested AND (deadline IS NULL OR deadline > $2))sql",
                             owner, now));
}

template <class Db>
std::vector<Kept> count_kept(Db& db) {
  auto row = db.query("SELECT owner, count(*) FROM jobs WHERE state >= 2 GROUP BY owner");
  std::vector<Kept> kept;
  while (row.next()) kept.push_back({row.text(0), count_in(row, 1)});
  return kept;
}

template <class Db>
std::vector<BlobKey> find_known_blobs(Db& db) {
  return keys_of<BlobKey>(db.query(
      "SELECT owner, mesh_a FROM jobs UNION SELECT owner, mesh_b FROM jobs UNION SELECT owner, id FROM meshes"));
}

template <class Db>
std::vector<BlobKey> find_used_blobs(Db& db) {
  return keys_of<BlobKey>(db.query(R"sql(
    SELECT owner, mesh_a FROM jobs WHERE state IN (0, 1)
    UNION SELECT owner, mesh_b FROM jobs WHERE state IN (0, 1)
    UNION SELECT owner, id FROM meshes)sql"));
}

// The blob $2 of the owner $1 is used by a mesh, or by a job that has not ended.
inline constexpr Sql kBlobIsUsed(R"sql(
      (EXISTS (SELECT 1 FROM meshes WHERE owner = $1 AND id = $2)
       OR EXISTS (SELECT 1 FROM jobs WHERE state IN (0, 1) AND owner = $1 AND mesh_a = $2)
       OR EXISTS (SELECT 1 FROM jobs WHERE state IN (0, 1) AND owner = $1 AND mesh_b = $2)))sql");
inline constexpr auto kUsesBlob = "SELECT 1 WHERE" + kBlobIsUsed;

// --- Batches ---

// Rows of the batches $1, $2; Db::kJobOfItem joins the items' jobs one by one, by the index of their keys.
template <class Db>
inline constexpr auto kFindBatch = R"sql(
    SELECT batches.name, batches.created, batches.cancel_requested, batches.fingerprint, count(item.position),
      count(*) FILTER (WHERE state = 0), count(*) FILTER (WHERE state = 1), count(*) FILTER (WHERE state = 2),
      count(*) FILTER (WHERE state = 3), count(*) FILTER (WHERE state = 4),
      count(*) FILTER (WHERE state = 2 AND verdict = 'pass'), count(*) FILTER (WHERE state = 2 AND verdict = 'fail'),
      count(*) FILTER (WHERE state = 2 AND verdict = 'undecided'), max(jobs.finished), max(jobs.expires)
    FROM batches LEFT JOIN batch_items AS item ON item.owner = batches.owner AND item.batch = batches.id )sql" +
                                   Db::kJobOfItem + R"sql(
    WHERE batches.owner = $1 AND batches.id = $2
    GROUP BY batches.owner, batches.id)sql";

struct FoundBatch {
  Batch batch;
  std::string fingerprint;
};

template <class Db>
std::optional<FoundBatch> find_batch(Db& db, const JobKey& key) {
  auto row = db.query(kFindBatch<Db>, key.owner, key.id);
  if (!row.next()) return std::nullopt;
  FoundBatch found{{key, row.text(0), row.time(1), row.number(2) != 0, {}, {}, {}}, row.text(3)};
  BatchCounts& counts = found.batch.counts;
  int column = 4;
  for (std::uint64_t* count : {&counts.total, &counts.queued, &counts.running, &counts.done, &counts.failed,
                               &counts.cancelled, &counts.pass, &counts.fail, &counts.undecided}) {
    *count = count_in(row, column++);
  }
  counts.gone = counts.total - counts.queued - counts.running - counts.done - counts.failed - counts.cancelled;
  if (counts.queued + counts.running > 0) return found;
  // A batch ends no earlier than it was created, even if all its work had been done before.
  const TimePoint finished = std::max(found.batch.created, row.time_if_any(column).value_or(found.batch.created));
  found.batch.finished = finished;
  found.batch.expires = std::max(finished, row.time_if_any(column + 1).value_or(finished));
  return found;
}

template <class Db>
std::optional<FoundBatch> find_idempotent_batch(Db& db, const std::string& owner, const std::string& key) {
  auto row = db.query("SELECT id FROM batches WHERE owner = $1 AND idempotency_key = $2", owner, key);
  return row.next() ? find_batch(db, {owner, row.text(0)}) : std::nullopt;
}

// What BatchStore::insert_batch() returns of a batch that is there already.
template <class Db>
std::optional<InsertedBatch> existing_batch(Db& db, const NewBatch& wanted) {
  std::optional<FoundBatch> there = find_batch(db, wanted.key);
  if (!there && !wanted.idempotency_key.empty()) {
    there = find_idempotent_batch(db, wanted.key.owner, wanted.idempotency_key);
  }
  if (!there) return std::nullopt;
  return InsertedBatch{std::move(there->batch), true, there->fingerprint != wanted.fingerprint, false};
}

inline std::optional<Batch> batch_of(std::optional<FoundBatch> found) {
  if (!found) return std::nullopt;
  return std::move(found->batch);
}

// The order of BatchStore::Rows::failures_first; NULL: not one of them.
inline constexpr Sql kBadness(R"sql(
      CASE WHEN state = 2 AND verdict = 'fail' THEN 1
           WHEN state = 3 THEN 2
           WHEN state = 2 AND verdict = 'undecided' THEN 3
           WHEN state = 4 THEN 4 END)sql");

template <class Db>
inline constexpr auto kItemsWithJobs = "SELECT" + kJobColumns + R"sql(, position, item_name
    FROM (SELECT item.position, item.name AS item_name, jobs.* FROM batch_items AS item )sql" +
                                       Db::kJobOfItem + R"sql(
      WHERE item.owner = $1 AND item.batch = $2 AND item.position >= $3 AND )sql";
inline constexpr Sql kByPosition(R"sql(
      ORDER BY item.position LIMIT $4) AS item
    ORDER BY position)sql");
template <class Db>
inline constexpr auto kEndedItems = kItemsWithJobs<Db> + "(state >= 2 OR state IS NULL)" + kByPosition;
template <class Db>
inline constexpr auto kRunningItems = kItemsWithJobs<Db> + "state = 1" + kByPosition;
template <class Db>
inline constexpr auto kFailedItems = kItemsWithJobs<Db> + kBadness + " IS NOT NULL ORDER BY" + kBadness +
                                     ", item.position LIMIT $4) AS item ORDER BY" + kBadness + ", position";

template <class Db>
std::vector<BatchRow> find_batch_rows(Db& db, const JobKey& key, BatchStore::Rows which, std::uint64_t from,
                                      std::size_t most) {
  const char* sql = kEndedItems<Db>;
  if (which == BatchStore::Rows::failures_first) sql = kFailedItems<Db>;
  if (which == BatchStore::Rows::running) sql = kRunningItems<Db>;
  auto row = db.query(sql, key.owner, key.id, from, most);
  std::vector<BatchRow> rows;
  while (row.next()) {
    rows.push_back({count_in(row, kJobColumnCount), row.text(kJobColumnCount + 1), std::nullopt});
    if (!row.is_null(0)) rows.back().job = job_of(row);
  }
  return rows;
}

template <class Db>
BatchStore::Load count_batches(Db& db, const std::string& owner) {
  auto row = db.query(R"sql(
    SELECT CAST(coalesce(sum(jobs), 0) AS bigint), count(*)
    FROM (SELECT batch, count(*) AS jobs FROM jobs
          WHERE state IN (0, 1) AND owner = $1 AND batch <> '' GROUP BY batch) AS mine)sql",
                      owner);
  row.next();
  return {count_in(row, 0), count_in(row, 1)};
}

// --- Meshes ---

inline constexpr Sql kMeshColumns("owner, id, bytes, media_type, file_name, created, last_used, expires");
inline constexpr auto kFindMesh = "SELECT " + kMeshColumns + " FROM meshes WHERE owner = $1 AND id = $2";

template <class Row>
std::optional<MeshRow> first_mesh(Row&& row) {
  if (!row.next()) return std::nullopt;
  return MeshRow{
      {row.text(0), row.text(1)}, count_in(row, 2), row.text(3), row.text(4), row.time(5), row.time(6), row.time(7)};
}

template <class Db>
std::optional<MeshRow> find_mesh(Db& db, const BlobKey& key) {
  return first_mesh(db.query(kFindMesh, key.owner, key.id));
}

template <class Db>
StoredMeshes find_stored(Db& db, const std::string& owner) {
  auto&& row = db.query("SELECT bytes, meshes FROM stored WHERE owner = $1", owner);
  return row.next() ? StoredMeshes{count_in(row, 0), count_in(row, 1)} : StoredMeshes{};
}

template <class Db>
std::uint64_t count_stored(Db& db) {
  return only_count(db.query("SELECT CAST(coalesce(sum(bytes), 0) AS bigint) FROM stored"));
}

// --- Listings ---

// The rows of a page: each table has an index of these three columns, so a page costs its own rows.
inline constexpr Sql kOfPage(R"sql(
    WHERE owner = $1 AND (created, id) < ($2, $3)
    ORDER BY created DESC, id DESC LIMIT $4)sql");

inline constexpr auto kListedMeshes = "SELECT " + kMeshColumns + " FROM meshes" + kOfPage;
inline constexpr auto kListedJobs = R"sql(
    SELECT owner, id, state, created, started, finished, expires, mesh_a, mesh_b, hints, verdict, batch
    FROM jobs)sql" + kOfPage;
inline constexpr auto kListedBatches = "SELECT owner, id, name, created, cancel_requested FROM batches" + kOfPage;

// The row of query(sql, owner, created, id, most).
template <class Db>
auto query_page(Db& db, const char* sql, const Page& page) {
  const Page::Place none{TimePoint(TimePoint::duration(std::numeric_limits<std::int64_t>::max())), ""};
  const Page::Place& after = page.after ? *page.after : none;
  return db.query(sql, page.owner, after.created, after.id, page.most);
}

template <class Db>
std::vector<MeshRow> list_meshes(Db& db, const Page& page) {
  auto row = query_page(db, kListedMeshes, page);
  std::vector<MeshRow> meshes;
  while (auto mesh = first_mesh(row)) meshes.push_back(*std::move(mesh));
  return meshes;
}

template <class Db>
std::vector<ListedJob> list_jobs(Db& db, const Page& page) {
  auto row = query_page(db, kListedJobs, page);
  std::vector<ListedJob> jobs;
  while (row.next()) {
    jobs.push_back({{row.text(0), row.text(1)},
                    static_cast<JobState>(row.number(2)),
                    row.time(3),
                    row.time_if_any(4),
                    row.time_if_any(5),
                    row.time_if_any(6),
                    row.text(7),
                    row.text(8),
                    row.text(9),
                    row.text(10),
                    row.text(11)});
  }
  return jobs;
}

template <class Db>
std::vector<ListedBatch> list_batches(Db& db, const Page& page) {
  std::map<std::string, std::uint64_t> unended;
  auto mine =
      db.query("SELECT batch, count(*) FROM jobs WHERE state IN (0, 1) AND owner = $1 AND batch <> '' GROUP BY batch",
               page.owner);
  while (mine.next()) unended.emplace(mine.text(0), count_in(mine, 1));
  std::vector<ListedBatch> batches;
  auto row = query_page(db, kListedBatches, page);
  while (row.next()) {
    const auto found = unended.find(row.text(1));
    batches.push_back({{row.text(0), row.text(1)},
                       row.text(2),
                       row.time(3),
                       row.number(4) != 0,
                       found == unended.end() ? 0 : found->second});
  }
  return batches;
}

template <class Db>
JobsOfOwner count_jobs_of(Db& db, const std::string& owner) {
  JobsOfOwner jobs;
  auto row =
      db.query("SELECT state, count(*) FROM jobs WHERE state IN (0, 1, 2, 3, 4) AND owner = $1 GROUP BY state", owner);
  while (row.next()) jobs.by_state.at(count_in(row, 0)) = count_in(row, 1);
  jobs.bytes = only_count(
      db.query("SELECT CAST(coalesce(sum(cost), 0) AS bigint) FROM jobs WHERE state IN (0, 1) AND owner = $1", owner));
  return jobs;
}

template <class Db>
std::uint64_t count_batches_of(Db& db, const std::string& owner) {
  return only_count(db.query("SELECT count(*) FROM batches WHERE owner = $1", owner));
}

}  // namespace meshgauge::server::store
