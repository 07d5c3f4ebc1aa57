// PostgresStore, except for claims and ends of jobs (running_jobs.cpp), hand-backs and sweeps (upkeep.cpp), and
// BatchStore (batches.cpp).
#include "server/store/postgres/postgres_store.h"

#include <utility>

#include "api/base/digest.h"
#include "server/store/policy.h"
#include "server/store/postgres/schema.h"
#include "server/store/rows.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

std::int64_t ms(TimePoint time) { return time.time_since_epoch().count(); }

std::optional<std::int64_t> ms(const std::optional<TimePoint>& time) {
  if (!time) return std::nullopt;
  return ms(*time);
}

// One member of all rows, as the array of a column.
template <class Of>
auto column(std::span<const JobRow> rows, Of of) {
  std::vector<std::decay_t<decltype(of(rows.front()))>> values;
  values.reserve(rows.size());
  for (const JobRow& row : rows) values.push_back(of(row));
  return values;
}

template <class Member>
auto column(std::span<const JobRow> rows, Member NewJob::*member) {
  return column(rows, [member](const JobRow& row) { return row.job.*member; });
}
template <class Member>
auto column(std::span<const JobRow> rows, Member Job::*member) {
  return column(rows, [member](const JobRow& row) { return row.job.*member; });
}
template <class Member>
auto column(std::span<const JobRow> rows, Member JobRow::*member) {
  return column(rows, [member](const JobRow& row) { return row.*member; });
}
template <class Time, class Class>
auto times(std::span<const JobRow> rows, Time Class::*member) {
  return column(rows, [member](const JobRow& row) { return ms(row.job.*member); });
}
template <class Member>
auto column(std::span<const JobRow> rows, Member Progress::*member) {
  return column(rows, [member](const JobRow& row) { return told(row.job.progress, member); });
}

constexpr auto kInsertJobs = "INSERT INTO jobs (" + kInsertedColumns + R"sql()
    SELECT owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, fingerprint, trace,
      created, expires_if_never_run, batch, deadline, tries, cancel_requested <> 0, started, finished, expires, lower,
      upper, stage, document, problem, last_error, verdict, work, bounds_by, client
    FROM unnest($1::bytea[], $2::bytea[], $3::int8[], $4::bytea[], $5::bytea[], $6::bytea[], $7::bytea[], $8::int8[],
        $9::int8[], $10::bytea[], $11::bytea[], $12::bytea[], $13::int8[], $14::int8[], $15::bytea[], $16::int8[],
        $17::int8[], $18::int8[], $19::int8[], $20::int8[], $21::int8[], $22::float8[], $23::float8[], $24::bytea[],
        $25::bytea[], $26::bytea[], $27::bytea[], $28::bytea[], $29::bytea[], $30::bytea[], $31::bytea[])
      WITH ORDINALITY AS given ()sql" +
                             kInsertedColumns + R"sql(, place)
    ORDER BY place
    ON CONFLICT DO NOTHING)sql";

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

constexpr std::int64_t kMeshPortion = 500;  // rows that one transaction removes

constexpr auto kUseMesh = R"sql(
    UPDATE meshes SET last_used = greatest(last_used, $3), expires = greatest(expires, $4)
    WHERE owner = $1 AND id = $2
    RETURNING )sql" + kMeshColumns;
constexpr auto kFindMeshes =
    "SELECT " + kMeshColumns + " FROM meshes WHERE owner = $1 AND id IN (SELECT unnest($2::bytea[]))";

// Returns what an owner has stored, locked until the end of the transaction.
StoredMeshes lock_stored(PgConnection& connection, const std::string& owner) {
  connection.query("INSERT INTO stored VALUES ($1, 0) ON CONFLICT DO NOTHING", owner);
  PgRows row = connection.query("SELECT bytes, meshes FROM stored WHERE owner = $1 FOR UPDATE", owner);
  return row.next() ? StoredMeshes{count_in(row, 0), count_in(row, 1)} : StoredMeshes{};
}

PutMesh put(PgConnection& connection, const MeshRow& mesh, const MeshQuota& quota) {
  PgTransaction transaction(connection);
  const StoredMeshes stored = lock_stored(connection, mesh.key.owner);
  auto there = first_mesh(connection.query(kUseMesh, mesh.key.owner, mesh.key.id, mesh.last_used, mesh.expires));
  if (there) {
    transaction.commit();
    return {MeshPut::existed, *std::move(there)};
  }
  const MeshPut what = fits(stored, mesh.bytes, quota);
  if (what != MeshPut::created) return {what, mesh};
  connection.query("INSERT INTO meshes VALUES ($1, $2, $3, $4, $5, $6, $7, $8)", mesh.key.owner, mesh.key.id,
                   mesh.bytes, mesh.media_type, mesh.file_name, mesh.created, mesh.last_used, mesh.expires);
  transaction.commit();
  return {MeshPut::created, mesh};
}

// Removes some expired meshes of one owner; returns their keys. Empty: there are none.
std::vector<BlobKey> remove_expired(PgConnection& connection, TimePoint now) {
  PgTransaction transaction(connection);
  PgRows oldest = connection.query("SELECT owner FROM meshes WHERE expires <= $1 ORDER BY expires LIMIT 1", now);
  if (!oldest.next()) return {};
  const std::string owner = oldest.text(0);
  lock_stored(connection, owner);
  // The first condition is checked again on a row that was locked: a mesh that was just used stays.
  auto removed = keys_of<BlobKey>(connection.query(R"sql(
    DELETE FROM meshes
    WHERE expires <= $2
      AND (owner, id) IN (SELECT owner, id FROM meshes WHERE owner = $1 AND expires <= $2 LIMIT $3)
    RETURNING owner, id)sql",
                                                   owner, now, kMeshPortion));
  transaction.commit();
  return removed;
}

}  // namespace

std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows) {
  const auto number = [](auto of) { return [of](const JobRow& row) { return static_cast<std::int64_t>(of(row)); }; };
  const PgValues values(
      column(rows, [](const JobRow& row) { return row.job.key.owner; }),
      column(rows, [](const JobRow& row) { return row.job.key.id; }),
      column(rows, number([](const JobRow& row) { return row.job.state; })), column(rows, &NewJob::mesh_a),
      column(rows, &NewJob::mesh_b), column(rows, &NewJob::hints), column(rows, &NewJob::options),
      column(rows, number([](const JobRow& row) { return row.job.cost; })),
      column(rows, [](const JobRow& row) { return rank_of(row.job); }),
      column(rows, [](const JobRow& row) { return none_if_empty(row.job.idempotency_key); }),
      column(rows, &NewJob::fingerprint), column(rows, &NewJob::trace), times(rows, &NewJob::created),
      times(rows, &NewJob::expires_if_never_run), column(rows, &NewJob::batch), times(rows, &NewJob::deadline),
      column(rows, number([](const JobRow& row) { return row.job.tries; })),
      column(rows, number([](const JobRow& row) { return row.job.cancel_requested; })), times(rows, &Job::started),
      times(rows, &Job::finished), times(rows, &Job::expires), column(rows, &Progress::lower),
      column(rows, &Progress::upper), column(rows, &Progress::stage), column(rows, &Job::document),
      column(rows, &Job::problem), column(rows, &Job::last_error), column(rows, &Job::verdict),
      column(rows, &JobRow::work),
      column(rows, [](const JobRow& row) { return row.job.progress ? row.job.progress->by : std::string(); }),
      column(rows, [](const JobRow& row) { return client_of(row.job); }));
  return connection.query(kInsertJobs, values).changed();
}

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
      control_({settings.database, settings.duty_grace, time_offset_ns}, pool_),
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
  if (!inserted) expect_failure();
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

Result<Done> PostgresStore::doubt(std::optional<TimePoint> since) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    connection.query("UPDATE origin SET doubted = $1", since);
    return Done{};
  });
}

Result<Done> PostgresStore::try_writing(bool a_job) {
  static const std::string process =
      api::random_id().substr(0, 2);  // few rows, and few processes that wait for the same one
  const auto found = pool_.run(Promise::durable, [&](PgConnection& connection) {
    const JobRow trial{trial_job(api::random_id(), time()), ""};
    const JobKey& key = trial.job.key;
    PgTransaction transaction(connection);
    if (a_job) insert_rows(connection, {&trial, 1});
    const bool is_there = !a_job || find_job(connection, key).has_value();
    connection.query("DELETE FROM jobs WHERE owner = $1 AND id = $2", key.owner, key.id);
    connection.query("INSERT INTO checks VALUES ($1, $2) ON CONFLICT (process) DO UPDATE SET at = excluded.at", process,
                     time());
    transaction.commit();
    return is_there;
  });
  if (!found) return found.error();
  if (*found) return Done{};
  return Error{ErrorCode::storage_damaged, "the database does not have what was just stored in it", "", ""};
}

Result<PutMesh> PostgresStore::put_mesh(const MeshRow& row, const MeshQuota& quota) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) { return put(connection, row, quota); });
}

Result<std::vector<MeshRow>> PostgresStore::known_meshes(const std::string& owner, std::span<const std::string> ids) {
  const std::vector<std::string> wanted(ids.begin(), ids.end());
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(kFindMeshes, owner, wanted);
    std::vector<MeshRow> known;
    while (auto mesh = first_mesh(row)) known.push_back(*std::move(mesh));
    return known;
  });
}

Result<bool> PostgresStore::delete_mesh(const BlobKey& key) {
  bool was_there = false;  // also in a try whose commit was not acknowledged
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    // Locks in the order of put_mesh(): first the owner's sum.
    PgTransaction transaction(connection);
    lock_stored(connection, key.owner);
    was_there |= connection.query("DELETE FROM meshes WHERE owner = $1 AND id = $2", key.owner, key.id).changed() == 1;
    transaction.commit();
    return was_there;
  });
}

// One owner at a time; locks the owner's sum first, as put_mesh() does.
Result<std::vector<BlobKey>> PostgresStore::sweep_meshes(TimePoint now) {
  Result<Done> flushed = flush();  // a mesh that was just used must stay
  if (!flushed) return flushed.error();
  for (std::vector<BlobKey> removed;;) {
    const auto portion =
        pool_.run(Promise::durable, [&](PgConnection& connection) { return remove_expired(connection, now); });
    if (!portion) return portion.error();
    if (portion->empty()) return removed;
    removed.insert(removed.end(), portion->begin(), portion->end());
  }
}

Result<Migrated> migrate_database(const std::string& database) {
  try {
    return pg_migrate(*PgConnection::open(database), pg_schema_steps());
  } catch (const PgFailure& failure) {
    return to_error(failure);
  }
}

template class CommonStore<PostgresStore>;

}  // namespace meshgauge::server::store
