// SqliteStore: BatchStore.
#include <algorithm>

#include "server/store/job_rows.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {
namespace {

std::uint64_t unsigned_number(const Query& row, int column) { return static_cast<std::uint64_t>(row.number(column)); }

// Work that is under way or done, and that nobody wants to stop.
std::optional<std::string> equal_work(Connection& connection, const std::string& owner, const std::string& work) {
  if (work.empty()) return std::nullopt;
  Query row(connection,
            "SELECT id FROM jobs WHERE owner = ? AND work = ? AND work != '' AND (state = 2 AND reusable OR state < 2 "
            "AND NOT cancel_requested) ORDER BY state DESC, number LIMIT 1",
            owner, work);
  if (!row.next()) return std::nullopt;
  return row.text(0);
}

std::string job_for(Connection& connection, const BatchItem& item) {
  std::optional<std::string> there = equal_work(connection, item.job.key.owner, item.work);
  if (there) return *std::move(there);
  insert_row(connection, item.job);
  Query(connection, "UPDATE jobs SET work = ? WHERE owner = ? AND id = ?", item.work, item.job.key.owner,
        item.job.key.id)
      .run();
  return item.job.key.id;
}

bool has_meshes(Connection& connection, const NewBatch& batch) {
  return std::all_of(batch.meshes.begin(), batch.meshes.end(), [&](const std::string& id) {
    return Query(connection, "SELECT 1 FROM meshes WHERE owner = ? AND id = ?", batch.key.owner, id).next();
  });
}

void insert_head(Connection& connection, const NewBatch& batch) {
  Query(connection,
        "INSERT INTO batches (owner, id, name, idempotency_key, fingerprint, created) VALUES (?, ?, ?, nullif(?, ''), "
        "?, ?)",
        batch.key.owner, batch.key.id, batch.name, batch.idempotency_key, batch.fingerprint, batch.created)
      .run();
}

void insert_items(Connection& connection, const NewBatch& batch) {
  std::uint64_t position = 0;
  for (const BatchItem& item : batch.items) {
    Query(connection, "INSERT INTO batch_items (owner, batch, position, name, job) VALUES (?, ?, ?, ?, ?)",
          batch.key.owner, batch.key.id, position++, item.name, job_for(connection, item))
        .run();
  }
}

// A batch as it is told of, and what is not told.
struct Found {
  Batch batch;
  std::string fingerprint;
};

// Of all items at once, in one statement: so the counts are of one moment.
#define MESHGAUGE_BATCH                                                                                              \
  "SELECT batches.owner, batches.id, batches.name, batches.created, batches.cancel_requested, batches.fingerprint, " \
  "count(*), sum(ifnull(state = 0, 0)), sum(ifnull(state = 1, 0)), sum(ifnull(state = 2, 0)), "                      \
  "sum(ifnull(state = 3, 0)), sum(ifnull(state = 4, 0)), sum(state IS NULL), "                                       \
  "sum(ifnull(state = 2 AND verdict = 'pass', 0)), sum(ifnull(state = 2 AND verdict = 'fail', 0)), "                 \
  "sum(ifnull(state = 2 AND verdict = 'undecided', 0)), max(finished), max(expires) FROM batches JOIN batch_items "  \
  "AS items ON items.owner = batches.owner AND items.batch = batches.id LEFT JOIN jobs ON jobs.owner = items.owner " \
  "AND jobs.id = items.job WHERE batches.owner = ? AND batches."

// A batch has not ended before it was made, even if all its work was done before.
std::optional<Found> found(Query& row) {
  if (!row.next() || row.number(6) == 0) return std::nullopt;
  std::optional<Found> result(std::in_place);
  Batch& batch = result->batch;
  batch.key = {row.text(0), row.text(1)};
  batch.name = row.text(2);
  batch.created = row.time(3);
  batch.cancel_requested = row.number(4) != 0;
  result->fingerprint = row.text(5);
  BatchCounts& counts = batch.counts;
  int column = 6;
  for (std::uint64_t* count : {&counts.total, &counts.queued, &counts.running, &counts.done, &counts.failed,
                               &counts.cancelled, &counts.gone, &counts.pass, &counts.fail, &counts.undecided}) {
    *count = unsigned_number(row, column++);
  }
  if (counts.queued + counts.running > 0) return result;
  batch.finished = std::max(batch.created, row.time_if_any(column).value_or(batch.created));
  batch.expires = std::max(*batch.finished, row.time_if_any(column + 1).value_or(*batch.finished));
  return result;
}

std::optional<Found> find_batch(Connection& connection, const JobKey& key) {
  Query row(connection, MESHGAUGE_BATCH "id = ?", key.owner, key.id);
  return found(row);
}

std::optional<Found> find_batch_of(Connection& connection, const std::string& owner, const std::string& key) {
  Query row(connection, MESHGAUGE_BATCH "idempotency_key = ?", owner, key);
  return found(row);
}

std::optional<Batch> batch_of(std::optional<Found> found) {
  if (!found) return std::nullopt;
  return std::move(found->batch);
}

#define MESHGAUGE_BATCH_ROWS                                                                                           \
  "SELECT " MESHGAUGE_JOB_COLUMNS                                                                                      \
  ", position, name FROM (SELECT owner AS item_owner, job, position, name FROM batch_items WHERE owner = ? AND batch " \
  "= ?) LEFT JOIN jobs ON jobs.owner = item_owner AND jobs.id = job WHERE "

std::vector<BatchRow> rows_of(Query& row) {
  std::vector<BatchRow> rows;
  while (row.next()) {
    BatchRow& added = rows.emplace_back();
    added.position = unsigned_number(row, kJobColumns);
    added.name = row.text(kJobColumns + 1);
    if (!row.is_null(0)) added.job = job_of(row);
  }
  return rows;
}

std::vector<BatchRow> ended_rows(Connection& connection, const JobKey& key, std::uint64_t from, std::size_t most) {
  Query row(connection, MESHGAUGE_BATCH_ROWS "position >= ? AND ifnull(state >= 2, 1) ORDER BY position LIMIT ?",
            key.owner, key.id, from, most);
  return rows_of(row);
}

std::vector<BatchRow> first_failures(Connection& connection, const JobKey& key, std::size_t most) {
  Query row(connection,
            MESHGAUGE_BATCH_ROWS
            "(state > 2 OR state = 2 AND verdict IN ('fail', 'undecided')) ORDER BY CASE WHEN state = 2 AND verdict = "
            "'fail' THEN 0 WHEN state = 3 THEN 1 WHEN state = 2 THEN 2 ELSE 3 END, position LIMIT ?",
            key.owner, key.id, most);
  return rows_of(row);
}

constexpr std::uint64_t kItemPortion = 250;  // items whose jobs one transaction cancels: other writes wait for it

// Of jobs that were asked for by these items of the batch, from this position on, and by no other that is still wanted.
// Returns those that run, and are to be told.
std::vector<JobKey> cancel_portion(Connection& connection, const JobKey& key, std::uint64_t from, Moment moment) {
  Query row(connection,
            "UPDATE jobs SET cancel_requested = 1, state = iif(state = 0, 4, 1), finished = iif(state = 0, ?1, "
            "NULL), expires = iif(state = 0, ?2, NULL) WHERE owner = ?3 AND state < 2 AND batch != '' AND id IN "
            "(SELECT job FROM batch_items WHERE owner = ?3 AND batch = ?4 AND position >= ?5 AND position < ?6) AND "
            "NOT EXISTS (SELECT 1 FROM batch_items AS other JOIN batches ON batches.owner = other.owner AND "
            "batches.id = other.batch WHERE other.owner = ?3 AND other.job = jobs.id AND NOT "
            "batches.cancel_requested) RETURNING owner, id, state",
            moment.now, moment.keep_until, key.owner, key.id, from, from + kItemPortion);
  std::vector<JobKey> running;
  while (row.next()) {
    if (static_cast<JobState>(row.number(2)) == JobState::running) running.push_back({row.text(0), row.text(1)});
  }
  return running;
}

// 0: there is no such batch.
std::uint64_t mark_cancelled(Connection& connection, const JobKey& key) {
  Query(connection, "UPDATE batches SET cancel_requested = 1 WHERE owner = ? AND id = ?", key.owner, key.id).run();
  Query row(connection, "SELECT ifnull(max(position) + 1, 0) FROM batch_items WHERE owner = ? AND batch = ?", key.owner,
            key.id);
  return row.next() ? unsigned_number(row, 0) : 0;
}

// Each job that is still to be cancelled is in a batch that was cancelled and made it.
std::vector<JobKey> half_cancelled(Connection& connection) {
  Query row(connection,
            "SELECT owner, id FROM batches AS its WHERE cancel_requested AND (EXISTS (SELECT 1 FROM jobs INDEXED BY "
            "jobs_waiting WHERE state = 0 AND owner = its.owner AND batch = its.id) OR EXISTS (SELECT 1 "
            "FROM jobs INDEXED BY jobs_running WHERE state = 1 AND NOT cancel_requested AND owner = its.owner AND "
            "batch = its.id))");
  return keys_of(row);
}

void remove_batch(Connection& connection, const JobKey& key) {
  Query(connection,
        "DELETE FROM jobs WHERE owner = ?1 AND batch != '' AND id IN (SELECT job FROM batch_items WHERE owner = ?1 AND "
        "batch = ?2) AND NOT EXISTS (SELECT 1 FROM batch_items WHERE owner = ?1 AND job = jobs.id AND batch != ?2)",
        key.owner, key.id)
      .run();
  Query(connection, "DELETE FROM batch_items WHERE owner = ? AND batch = ?", key.owner, key.id).run();
  Query(connection, "DELETE FROM batches WHERE owner = ? AND id = ?", key.owner, key.id).run();
}

std::optional<JobKey> ended_batch(Connection& connection, TimePoint ended_before) {
  Query row(connection,
            "SELECT owner, id FROM batches WHERE created < ?1 AND NOT EXISTS (SELECT 1 FROM batch_items AS items JOIN "
            "jobs ON jobs.owner = items.owner AND jobs.id = items.job WHERE items.owner = batches.owner AND "
            "items.batch = batches.id AND (state < 2 OR finished >= ?1)) LIMIT 1",
            ended_before);
  if (!row.next()) return std::nullopt;
  return JobKey{row.text(0), row.text(1)};
}

}  // namespace

Result<InsertedBatch> SqliteStore::insert_batch(const NewBatch& batch) {
  auto inserted = writer_.write([&](Connection& connection) -> InsertedBatch {
    std::optional<Found> there = find_batch(connection, batch.key);
    if (!there) there = find_batch_of(connection, batch.key.owner, batch.idempotency_key);
    if (there) return {std::move(there->batch), true, there->fingerprint != batch.fingerprint, false};
    if (batch.repeats) return {{}, false, false, false, true};
    if (!has_meshes(connection, batch)) return {{}, false, false, true};
    insert_head(connection, batch);
    insert_items(connection, batch);
    return {std::move(find_batch(connection, batch.key)->batch), false, false, false};
  });
  if (inserted && !inserted->existed) signals_.tell(Signal::Kind::work);
  return inserted;
}

Result<std::optional<Batch>> SqliteStore::get_batch(const JobKey& key) {
  return readers_.read([&](Connection& connection) { return batch_of(find_batch(connection, key)); });
}

Result<std::optional<Batch>> SqliteStore::find_idempotent_batch(const std::string& owner,
                                                                const std::string& idempotency_key) {
  return readers_.read(
      [&](Connection& connection) { return batch_of(find_batch_of(connection, owner, idempotency_key)); });
}

Result<std::vector<BatchRow>> SqliteStore::batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                                      std::size_t most) {
  return readers_.read([&](Connection& connection) {
    return which == Rows::ended ? ended_rows(connection, key, from, most) : first_failures(connection, key, most);
  });
}

Result<bool> SqliteStore::cancel_batch(const JobKey& key, Moment moment) {
  const Result<std::uint64_t> items =
      writer_.write([&](Connection& connection) { return mark_cancelled(connection, key); });
  if (!items) return items.error();
  for (std::uint64_t from = 0; from < *items; from += kItemPortion) {
    const auto running =
        writer_.write([&](Connection& connection) { return cancel_portion(connection, key, from, moment); });
    if (!running) return running.error();
    for (const JobKey& job : *running) signals_.tell(Signal::Kind::cancel, job);
  }
  return *items > 0;
}

Result<Done> SqliteStore::cancel_the_rest(Moment moment) {
  const Result<std::vector<JobKey>> keys = readers_.read(half_cancelled);
  if (!keys) return keys.error();
  for (const JobKey& key : *keys) {
    if (const Result<bool> cancelled = cancel_batch(key, moment); !cancelled) return cancelled.error();
  }
  return Done{};
}

Result<bool> SqliteStore::forget_batch(const JobKey& key) {
  return writer_.write([&](Connection& connection) {
    const std::optional<Batch> batch = batch_of(find_batch(connection, key));
    if (!batch || !batch->finished) return false;
    remove_batch(connection, key);
    return true;
  });
}

Result<BatchStore::Load> SqliteStore::batch_load(const std::string& owner) {
  return readers_.read([&](Connection& connection) {
    Query row(connection,
              "SELECT count(*), count(DISTINCT batch) FROM jobs WHERE state IN (0, 1) AND owner = ? AND batch != ''",
              owner);
    row.next();
    return Load{static_cast<std::uint64_t>(row.number(0)), static_cast<std::uint64_t>(row.number(1))};
  });
}

// One a transaction: other writes wait for it.
Result<std::uint64_t> SqliteStore::sweep_batches(TimePoint ended_before) {
  std::uint64_t swept = 0;
  while (true) {
    const Result<bool> removed = writer_.write([&](Connection& connection) {
      const std::optional<JobKey> key = ended_batch(connection, ended_before);
      if (key) remove_batch(connection, *key);
      return key.has_value();
    });
    if (!removed) return removed.error();
    if (!*removed) return swept;
    ++swept;
  }
}

}  // namespace meshgauge::server::store
