// SqliteStore: BatchStore.
#include <algorithm>

#include "server/store/rows.h"
#include "server/store/sqlite_store.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

// The job that does this work already, if it is under way and not cancelled, or has ended reusable.
std::optional<std::string> equal_work(Connection& connection, const std::string& owner, const std::string& work) {
  if (work.empty()) return std::nullopt;
  Query row = connection.query(R"sql(
    SELECT id FROM jobs
    WHERE owner = $1 AND work = $2 AND work <> ''
      AND ((state < 2 AND NOT cancel_requested) OR (state = 2 AND reusable))
    ORDER BY state DESC, number LIMIT 1)sql",
                               owner, work);
  if (!row.next()) return std::nullopt;
  return row.text(0);
}

std::string job_for(Connection& connection, const BatchItem& item) {
  std::optional<std::string> there = equal_work(connection, item.job.key.owner, item.work);
  if (there) return *std::move(there);
  insert_row(connection, as_queued(item.job), item.work);
  return item.job.key.id;
}

bool has_meshes(Connection& connection, const NewBatch& batch) {
  return std::all_of(batch.meshes.begin(), batch.meshes.end(), [&](const std::string& id) {
    return connection.query("SELECT 1 FROM meshes WHERE owner = $1 AND id = $2", batch.key.owner, id).next();
  });
}

void insert_head(Connection& connection, const NewBatch& batch) {
  connection
      .query(R"sql(
    INSERT INTO batches (owner, id, name, idempotency_key, fingerprint, created)
    VALUES ($1, $2, $3, nullif($4, ''), $5, $6))sql",
             batch.key.owner, batch.key.id, batch.name, batch.idempotency_key, batch.fingerprint, batch.created)
      .run();
}

void insert_items(Connection& connection, const NewBatch& batch) {
  std::uint64_t position = 0;
  for (const BatchItem& item : batch.items) {
    const std::string job = job_for(connection, item);
    connection
        .query("INSERT INTO batch_items (owner, batch, position, name, job) VALUES ($1, $2, $3, $4, $5)",
               batch.key.owner, batch.key.id, position++, item.name, job)
        .run();
  }
}

constexpr std::uint64_t kItemPortion = 250;  // items whose jobs one transaction cancels: other writes wait for it

constexpr auto kCancelItems = "UPDATE jobs SET" + kCancel + " WHERE owner = $1 AND " + kCancellable + R"sql(
      AND batch <> ''
      AND id IN (SELECT job FROM batch_items WHERE owner = $1 AND batch = $2 AND position >= $5 AND position < $6)
      AND NOT EXISTS (SELECT 1 FROM batch_items AS other
                      JOIN batches ON batches.owner = other.owner AND batches.id = other.batch
                      WHERE other.owner = $1 AND other.job = jobs.id AND NOT batches.cancel_requested)
    RETURNING owner, id, state)sql";

// Cancels the jobs of the batch's items from this position on, unless another batch that is not cancelled points at
// them. Returns those that run, whose workers are to be told.
std::vector<JobKey> cancel_portion(Connection& connection, const JobKey& key, std::uint64_t from, Moment moment) {
  Query row =
      connection.query(kCancelItems, key.owner, key.id, moment.now, moment.keep_until, from, from + kItemPortion);
  std::vector<JobKey> running;
  while (row.next()) {
    if (static_cast<JobState>(row.number(2)) == JobState::running) running.push_back({row.text(0), row.text(1)});
  }
  return running;
}

// Returns the number of items. 0: there is no such batch.
std::uint64_t mark_cancelled(Connection& connection, const JobKey& key) {
  connection.query("UPDATE batches SET cancel_requested = true WHERE owner = $1 AND id = $2", key.owner, key.id).run();
  return only_count(connection.query(
      "SELECT ifnull(max(position) + 1, 0) FROM batch_items WHERE owner = $1 AND batch = $2", key.owner, key.id));
}

// Cancelled batches of which a job is still to be cancelled: such a job belongs to the batch that made it.
std::vector<JobKey> half_cancelled(Connection& connection) {
  return keys_of<JobKey>(connection.query(R"sql(
    SELECT owner, id FROM batches AS its
    WHERE cancel_requested
      AND (EXISTS (SELECT 1 FROM jobs INDEXED BY jobs_waiting
                   WHERE state = 0 AND owner = its.owner AND batch = its.id)
           OR EXISTS (SELECT 1 FROM jobs INDEXED BY jobs_running
                      WHERE state = 1 AND NOT cancel_requested AND owner = its.owner AND batch = its.id)))sql"));
}

void remove_batch(Connection& connection, const JobKey& key) {
  connection
      .query(R"sql(
    DELETE FROM jobs
    WHERE owner = $1 AND batch <> ''
      AND id IN (SELECT job FROM batch_items WHERE owner = $1 AND batch = $2)
      AND NOT EXISTS (SELECT 1 FROM batch_items WHERE owner = $1 AND job = jobs.id AND batch <> $2))sql",
             key.owner, key.id)
      .run();
  connection.query("DELETE FROM batch_items WHERE owner = $1 AND batch = $2", key.owner, key.id).run();
  connection.query("DELETE FROM batches WHERE owner = $1 AND id = $2", key.owner, key.id).run();
}

std::vector<JobKey> first_ended_batch(Connection& connection, TimePoint ended_before) {
  return keys_of<JobKey>(connection.query(R"sql(
    SELECT owner, id FROM batches
    WHERE created < $1
      AND NOT EXISTS (SELECT 1 FROM batch_items AS item
                      JOIN jobs ON jobs.owner = item.owner AND jobs.id = item.job
                      WHERE item.owner = batches.owner AND item.batch = batches.id AND (state < 2 OR finished >= $1))
    LIMIT 1)sql",
                                          ended_before));
}

}  // namespace

Result<InsertedBatch> SqliteStore::insert_batch(const NewBatch& batch) {
  auto inserted = writer_.write([&](Connection& connection) -> InsertedBatch {
    if (auto there = existing_batch(connection, batch)) return *std::move(there);
    if (batch.repeats) return {{}, false, false, false, true};
    if (!has_meshes(connection, batch)) return {{}, false, false, true};
    insert_head(connection, batch);
    insert_items(connection, batch);
    return {std::move(find_batch(connection, batch.key)->batch), false, false, false};
  });
  if (inserted && !inserted->existed) signals_.tell(Signal::Kind::work);
  return inserted;
}

Result<bool> SqliteStore::cancel_batch(const JobKey& key, Moment moment) {
  const Result<std::uint64_t> items =
      writer_.write([&](Connection& connection) { return mark_cancelled(connection, key); }, Writer::Promise::removal);
  if (!items) return items.error();
  for (std::uint64_t from = 0; from < *items; from += kItemPortion) {
    const auto running =
        writer_.write([&](Connection& connection) { return cancel_portion(connection, key, from, moment); },
                      Writer::Promise::removal);
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
  return writer_.write(
      [&](Connection& connection) {
        const std::optional<Batch> batch = batch_of(find_batch(connection, key));
        if (!batch || !batch->finished) return false;
        remove_batch(connection, key);
        return true;
      },
      Writer::Promise::removal);
}

// One batch a transaction: other writes wait for it.
Result<std::uint64_t> SqliteStore::sweep_batches(TimePoint ended_before) {
  std::uint64_t swept = 0;
  while (true) {
    const Result<bool> removed = writer_.write(
        [&](Connection& connection) {
          const std::vector<JobKey> ended = first_ended_batch(connection, ended_before);
          for (const JobKey& key : ended) remove_batch(connection, key);
          return !ended.empty();
        },
        Writer::Promise::removal);
    if (!removed) return removed.error();
    if (!*removed) return swept;
    ++swept;
  }
}

}  // namespace meshgauge::server::store
