#include "server/store/postgres/postgres_store.h"

#include <cassert>
#include <utility>

#include "api/digest.h"
#include "server/store/postgres/job_rows.h"
#include "server/store/postgres/schema.h"
#include "server/store/rows.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

constexpr auto kCancelByKey =
    "UPDATE jobs SET" + kCancel + " WHERE owner = $1 AND id = $2 AND " + kCancellable + " RETURNING state";
constexpr auto kFindJobs =
    "SELECT" + kJobColumns + " FROM jobs WHERE (owner, id) IN (SELECT * FROM unnest($1::bytea[], $2::bytea[]))";

std::optional<JobState> cancel(PgConnection& connection, const JobKey& key, Moment moment) {
  PgRows row = connection.query(kCancelByKey, key.owner, key.id, moment.now, moment.keep_until);
  if (row.next()) return static_cast<JobState>(row.number(0));
  const std::optional<Job> ended = find_job(connection, key);
  if (!ended) return std::nullopt;
  connection.put_barrier();
  return ended->state;
}

// One statement, since there may be ten thousand. Locks in one order, because other processes write touches of the same
// meshes.
void write_touches(PgConnection& connection, const WriteBehind::Touches& touches) {
  if (touches.empty()) return;
  std::vector<std::string> owners, ids;
  std::vector<std::int64_t> used, expires;
  for (const auto& [mesh, touch] : touches) {
    owners.push_back(mesh.owner);
    ids.push_back(mesh.id);
    used.push_back(touch.last_used.time_since_epoch().count());
    expires.push_back(touch.expires.time_since_epoch().count());
  }
  connection.query(R"sql(
    WITH locked AS MATERIALIZED (
      SELECT touch.*
      FROM (SELECT * FROM unnest($1::bytea[], $2::bytea[], $3::int8[], $4::int8[])
              AS touch (owner, id, last_used, expires)
            ORDER BY owner, id) AS touch
      CROSS JOIN LATERAL (SELECT 1 FROM meshes WHERE owner = touch.owner AND id = touch.id FOR NO KEY UPDATE) AS found)
    UPDATE meshes SET
      last_used = greatest(meshes.last_used, locked.last_used), expires = greatest(meshes.expires, locked.expires)
    FROM locked WHERE meshes.owner = locked.owner AND meshes.id = locked.id)sql",
                   owners, ids, used, expires);
}

}  // namespace

Result<std::unique_ptr<PostgresStore>> PostgresStore::open(const PostgresSettings& settings) {
  try {
    const std::unique_ptr<PgConnection> connection = PgConnection::open(settings.database);
    const Result<Migrated> migrated = pg_migrate(*connection, pg_schema_steps());
    if (!migrated) return migrated.error();
    if (settings.report && migrated->changed()) settings.report(to_string(*migrated));
    return std::unique_ptr<PostgresStore>(new PostgresStore(settings, clock_offset_ns(*connection)));
  } catch (const PgFailure& failure) {
    return to_error(failure);
  }
}

PostgresStore::PostgresStore(const PostgresSettings& settings, std::int64_t time_offset_ns)
    : pool_({settings.database, settings.max_connections, settings.call_timeout, settings.report}),
      control_({settings.database, settings.duty_grace, time_offset_ns}, [this] { return pool_.newest_trouble(); }),
      behind_(settings.max_unrecorded, [this](const WriteBehind::Batch& batch) { return write(batch); }) {}

Result<Inserted> PostgresStore::insert(const NewJob& job) {
  Result<Inserted> inserted = pool_.run(Promise::durable, [&](PgConnection& connection) {
    const JobRow row{as_queued(job), ""};
    if (insert_rows(connection, {&row, 1}) == 1) return Inserted{row.job, false, false};
    if (auto there = existing_job(connection, job)) {
      connection.put_barrier();
      return *std::move(there);
    }
    throw PgFailure{"40001", "a job was removed while it was read", false, true};
  });
  if (inserted && !inserted->existed) control_.tell(Signal::Kind::work);
  return inserted;
}

Result<std::optional<JobState>> PostgresStore::request_cancel(const JobKey& key, Moment moment) {
  if (const auto job = behind_.find(key)) return std::optional(job->state);
  Result<std::optional<JobState>> state =
      pool_.run(Promise::durable, [&](PgConnection& connection) { return cancel(connection, key, moment); });
  if (!state || !*state) return state;
  if (*state == JobState::running) control_.tell(Signal::Kind::cancel, key);
  if (*state == JobState::cancelled) control_.tell(Signal::Kind::changed, key);
  return state;
}

Result<Done> PostgresStore::write(const WriteBehind::Batch& batch) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    std::vector<JobRow> rows;
    for (const auto& job : batch.jobs) rows.push_back({*job, ""});
    PgTransaction transaction(connection);
    if (!rows.empty()) insert_rows(connection, rows);
    write_touches(connection, batch.touches);
    transaction.commit();
    return Done{};
  });
}

Result<std::optional<Job>> PostgresStore::get(const JobKey& key) {
  if (const auto job = behind_.find(key)) return std::optional<Job>(*job);
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find_job(connection, key); });
}

Result<std::vector<Job>> PostgresStore::get_many(std::span<const JobKey> keys) {
  std::vector<Job> jobs;
  std::vector<std::string> owners, ids;
  for (const JobKey& key : keys) {
    if (const auto job = behind_.find(key)) {
      jobs.push_back(*job);
      continue;
    }
    owners.push_back(key.owner);
    ids.push_back(key.id);
  }
  if (ids.empty()) return jobs;
  const auto stored = pool_.run(
      Promise::fleeting, [&](PgConnection& connection) { return jobs_of(connection.query(kFindJobs, owners, ids)); });
  if (!stored) return stored.error();
  jobs.insert(jobs.end(), stored->begin(), stored->end());
  return jobs;
}

Result<std::optional<Job>> PostgresStore::find_idempotent(const std::string& owner,
                                                          const std::string& idempotency_key) {
  return pool_.run(Promise::fleeting,
                   [&](PgConnection& connection) { return find_idempotent_job(connection, owner, idempotency_key); });
}

Result<Origin> PostgresStore::origin() { return pool_.run(Promise::fleeting, find_origin<PgConnection>); }

Result<Done> PostgresStore::doubt(std::optional<TimePoint> since) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    connection.query("UPDATE origin SET doubted = $1", since);
    return Done{};
  });
}

Result<Done> PostgresStore::check() {
  static const std::string process =
      api::random_id().substr(0, 2);  // few rows, and few processes that wait for the same one
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    connection.query("INSERT INTO checks VALUES ($1, $2) ON CONFLICT (process) DO UPDATE SET at = excluded.at", process,
                     time());
    return Done{};
  });
}

Result<Migrated> migrate_database(const std::string& database) {
  try {
    return pg_migrate(*PgConnection::open(database), pg_schema_steps());
  } catch (const PgFailure& failure) {
    return to_error(failure);
  }
}

}  // namespace meshgauge::server::store
