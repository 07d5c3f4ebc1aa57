#include "server/store/postgres/schema.h"

#include <chrono>
#include <thread>

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kLock = 0x4d474a31;  // "MGJ1": held by the process that migrates this database
constexpr std::chrono::seconds kTables{1};  // between two attempts to lock the tables

// Text is bytea (connection.h), ordered by its bytes, also in indexes.
constexpr const char* kFirst = R"sql(
CREATE TABLE jobs (
  number bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  owner bytea NOT NULL,
  id bytea NOT NULL,
  state smallint NOT NULL CHECK (state BETWEEN 0 AND 4),  -- JobState: queued, running, done, failed, cancelled
  mesh_a bytea NOT NULL,
  mesh_b bytea NOT NULL,
  hints bytea NOT NULL,
  options bytea NOT NULL,
  cost bigint NOT NULL,
  rank bigint NOT NULL,                    -- order of claim_some(): see rank_of()
  idempotency_key bytea,
  fingerprint bytea NOT NULL,
  trace bytea NOT NULL,
  created bigint NOT NULL,                 -- times: milliseconds since 1970
  expires_if_never_run bigint NOT NULL,
  tries integer NOT NULL DEFAULT 0,
  excused integer NOT NULL DEFAULT 0,      -- tries that ended without the job's fault
  worker bytea NOT NULL DEFAULT '',        -- with tries: the newest token
  lease_until bigint,
  cancel_requested boolean NOT NULL DEFAULT false,
  started bigint,
  finished bigint,
  expires bigint,
  lower float8,
  upper float8,
  stage bytea,
  document bytea NOT NULL DEFAULT '',
  problem bytea NOT NULL DEFAULT '',
  last_error bytea NOT NULL DEFAULT '',
  CHECK ((state >= 2) = (finished IS NOT NULL AND expires IS NOT NULL)),
  UNIQUE (owner, id)
);
CREATE UNIQUE INDEX jobs_idempotent ON jobs (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX jobs_by_state ON jobs (state, owner);
CREATE INDEX jobs_expiring ON jobs (expires) WHERE state >= 2;
CREATE INDEX jobs_finished ON jobs (owner, finished, number) WHERE state >= 2;
CREATE INDEX jobs_never_run ON jobs (expires_if_never_run) WHERE state = 0;
-- A queue's rows come and go: what is dead must be cleared away before it slows the search for what waits. Heartbeats
-- change nothing that is in an index, and find room beside the row.
ALTER TABLE jobs SET (fillfactor = 80, autovacuum_vacuum_scale_factor = 0.02, autovacuum_vacuum_insert_scale_factor = 0.05,
                      autovacuum_analyze_scale_factor = 0.05, autovacuum_vacuum_cost_delay = 1);

CREATE TABLE meshes (
  owner bytea NOT NULL,
  id bytea NOT NULL,
  bytes bigint NOT NULL,
  media_type bytea NOT NULL,
  file_name bytea NOT NULL,
  created bigint NOT NULL,
  last_used bigint NOT NULL,
  expires bigint NOT NULL,
  PRIMARY KEY (owner, id)
);
CREATE INDEX meshes_expiring ON meshes (expires);

-- The sum of meshes.bytes of each owner, kept by the triggers.
CREATE TABLE stored (owner bytea PRIMARY KEY, bytes bigint NOT NULL);
CREATE FUNCTION meshgauge_mesh_added() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO stored AS mine VALUES (new.owner, new.bytes)
    ON CONFLICT (owner) DO UPDATE SET bytes = mine.bytes + new.bytes;
  RETURN NULL;
END $$;
CREATE FUNCTION meshgauge_mesh_removed() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  UPDATE stored SET bytes = bytes - old.bytes WHERE owner = old.owner;
  RETURN NULL;
END $$;
CREATE TRIGGER mesh_added AFTER INSERT ON meshes FOR EACH ROW EXECUTE FUNCTION meshgauge_mesh_added();
CREATE TRIGGER mesh_removed AFTER DELETE ON meshes FOR EACH ROW EXECUTE FUNCTION meshgauge_mesh_removed();

CREATE TABLE checks (process bytea PRIMARY KEY, at bigint NOT NULL);
)sql";

constexpr const char* kSecond = R"sql(
ALTER TABLE jobs
  ADD COLUMN batch bytea NOT NULL DEFAULT '',
  ADD COLUMN deadline bigint,
  ADD COLUMN verdict bytea NOT NULL DEFAULT '',
  ADD COLUMN work bytea NOT NULL DEFAULT '',       -- BatchItem::work
  ADD COLUMN reusable boolean NOT NULL DEFAULT false,
  ADD COLUMN parent bytea NOT NULL DEFAULT '',     -- id of the whole that it is a part of
  ADD COLUMN awaits integer NOT NULL DEFAULT 0,    -- parts that have not ended
  ADD COLUMN claim bigint;                         -- which call of claim() or claim_some() has it
DROP INDEX jobs_finished, jobs_by_state;
CREATE INDEX jobs_by_state ON jobs (state) WHERE parent = '';
CREATE INDEX jobs_finished ON jobs (owner, finished, number) WHERE state >= 2 AND parent = '';
CREATE INDEX jobs_waiting ON jobs (owner, batch, rank, number) WHERE state = 0 AND awaits = 0;
CREATE INDEX jobs_oldest ON jobs (created) WHERE state = 0;
CREATE INDEX jobs_unawaited ON jobs (state) WHERE state IN (0, 1) AND batch = '' AND deadline IS NULL AND parent = '';
CREATE INDEX jobs_running ON jobs (owner, batch) WHERE state = 1;
CREATE INDEX jobs_by_work ON jobs (owner, work) WHERE work <> '';
CREATE INDEX jobs_by_parent ON jobs (owner, parent, number) WHERE parent <> '';
CREATE INDEX jobs_using_a ON jobs (owner, mesh_a) WHERE state IN (0, 1);
CREATE INDEX jobs_using_b ON jobs (owner, mesh_b) WHERE state IN (0, 1);

CREATE TABLE batches (
  owner bytea NOT NULL,
  id bytea NOT NULL,
  name bytea NOT NULL,
  idempotency_key bytea,
  fingerprint bytea NOT NULL,
  created bigint NOT NULL,
  cancel_requested boolean NOT NULL DEFAULT false,
  PRIMARY KEY (owner, id)
);
CREATE UNIQUE INDEX batches_idempotent ON batches (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE TABLE batch_items (
  owner bytea NOT NULL,
  batch bytea NOT NULL,
  position bigint NOT NULL,
  name bytea NOT NULL,
  job bytea NOT NULL,                              -- jobs.id
  PRIMARY KEY (owner, batch, position)
);
CREATE INDEX batch_items_by_job ON batch_items (owner, job);
)sql";

constexpr const char* kThird = R"sql(
-- Blobs, where no other place for them is set (pg_blobs.h). A blob is there when its row is; all of its chunks are.
CREATE TABLE blobs (
  owner bytea NOT NULL,
  id bytea NOT NULL,
  bytes bigint NOT NULL,
  upload bytea NOT NULL,                           -- whose chunks are its bytes
  renewed bigint NOT NULL,
  PRIMARY KEY (owner, id)
);
CREATE INDEX blobs_by_age ON blobs (renewed);
CREATE TABLE blob_chunks (
  upload bytea NOT NULL,
  position integer NOT NULL,
  bytes bytea NOT NULL,
  PRIMARY KEY (upload, position)
);
-- Meshes are compressed where they come from, or do not compress well: it would cost more than it saves.
ALTER TABLE blob_chunks ALTER COLUMN bytes SET STORAGE EXTERNAL;
-- Uploads that have no blob yet; begun 0: no blob any more, to be removed.
CREATE TABLE blob_uploads (upload bytea PRIMARY KEY, begun bigint NOT NULL);
CREATE INDEX blob_uploads_by_age ON blob_uploads (begun);
CREATE TABLE blob_bytes (owner bytea PRIMARY KEY, bytes bigint NOT NULL);  -- sums of blobs.bytes
)sql";

constexpr const char* kFourth = R"sql(
ALTER TABLE jobs ADD COLUMN bounds_by bytea NOT NULL DEFAULT '';  -- Progress::by
-- One step from an owner that waits to the next. Only claim_some() uses it, by its last condition.
CREATE INDEX jobs_turns ON jobs (owner, rank) WHERE state = 0 AND awaits = 0 AND tries >= 0;
-- Processes of the version before change bounds and leave bounds_by as it is: clear it, since it is wrong then.
CREATE FUNCTION meshgauge_bounds_of_unknown() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  new.bounds_by := '';
  RETURN new;
END $$;
CREATE TRIGGER bounds_of_unknown BEFORE UPDATE OF lower, upper ON jobs FOR EACH ROW
  WHEN (coalesce(current_setting('meshgauge.bounds_by', true), '') = ''
        AND (new.lower IS DISTINCT FROM old.lower OR new.upper IS DISTINCT FROM old.upper))
  EXECUTE FUNCTION meshgauge_bounds_of_unknown();
)sql";

constexpr const char* kFifth = R"sql(
-- On request (option "shards") a comparison was measured in parts, each a row. The parts go; the worker that claims the
-- whole measures it in one piece. The pattern matches members of options alone: in a string, quotes are escaped.
DELETE FROM jobs WHERE parent <> '';
UPDATE jobs SET options = decode(regexp_replace(encode(options, 'escape'),
    ',\s*"shards"\s*:\s*[0-9]+|"shards"\s*:\s*[0-9]+\s*,?', ''), 'escape')
  WHERE state < 2 AND position('"shards"'::bytea IN options) > 0;
DROP INDEX jobs_by_state, jobs_finished, jobs_waiting, jobs_unawaited, jobs_by_parent, jobs_turns;
ALTER TABLE jobs DROP COLUMN parent, DROP COLUMN awaits;
CREATE INDEX jobs_by_state ON jobs (state);
CREATE INDEX jobs_finished ON jobs (owner, finished, number) WHERE state >= 2;
CREATE INDEX jobs_waiting ON jobs (owner, batch, rank, number) WHERE state = 0;
CREATE INDEX jobs_unawaited ON jobs (state) WHERE state IN (0, 1) AND batch = '' AND deadline IS NULL;
CREATE INDEX jobs_turns ON jobs (owner, rank) WHERE state = 0 AND tries >= 0;
)sql";

constexpr const char* kSixth = R"sql(
CREATE TABLE origin (one boolean PRIMARY KEY DEFAULT true CHECK (one), born bigint NOT NULL, doubted bigint);  -- Origin
INSERT INTO origin (born) SELECT min(at) FROM (
  SELECT created AS at FROM jobs UNION ALL SELECT created FROM meshes UNION ALL SELECT created FROM batches
  UNION ALL SELECT floor(1000 * extract(epoch FROM clock_timestamp()))::bigint) AS times;

ALTER TABLE stored ADD COLUMN meshes bigint NOT NULL DEFAULT 0;  -- their number
LOCK TABLE meshes IN SHARE ROW EXCLUSIVE MODE;
UPDATE stored SET meshes = (SELECT count(*) FROM meshes WHERE meshes.owner = stored.owner);
CREATE OR REPLACE FUNCTION meshgauge_mesh_added() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  INSERT INTO stored AS mine VALUES (new.owner, new.bytes, 1)
    ON CONFLICT (owner) DO UPDATE SET bytes = mine.bytes + new.bytes, meshes = mine.meshes + 1;
  RETURN NULL;
END $$;
CREATE OR REPLACE FUNCTION meshgauge_mesh_removed() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  UPDATE stored SET bytes = bytes - old.bytes, meshes = meshes - 1 WHERE owner = old.owner;
  RETURN NULL;
END $$;
)sql";

constexpr const char* kSeventh = R"sql(
ALTER TABLE jobs ADD COLUMN client bytea NOT NULL DEFAULT '';  -- client_of() a job; '': the version before queued it
UPDATE jobs SET client = owner WHERE state < 2 AND owner <> '';
DROP INDEX jobs_turns, jobs_running;
CREATE INDEX jobs_turns ON jobs (client, rank) WHERE state = 0 AND tries >= 0;
CREATE INDEX jobs_of_client ON jobs (client, batch, rank, number) WHERE state = 0;
CREATE INDEX jobs_running ON jobs (client, batch) WHERE state = 1;
)sql";

// kGoesFirst of each owner.
constexpr const char* kEighth = R"sql(
DROP INDEX jobs_finished;
CREATE INDEX jobs_finished ON jobs (owner, (worker <> '' OR tries <> 1), finished, number) WHERE state >= 2;
)sql";

// The order of Listings.
constexpr const char* kNinth = R"sql(
CREATE INDEX jobs_newest ON jobs (owner, created, id) INCLUDE (state);
CREATE INDEX meshes_newest ON meshes (owner, created, id);
CREATE INDEX batches_newest ON batches (owner, created, id);
)sql";

constexpr const char* kSteps[] = {kFirst, kSecond, kThird, kFourth, kFifth, kSixth, kSeventh, kEighth, kNinth};

Error unusable_database(const std::string& why) { return {ErrorCode::internal, "the database " + why, "", ""}; }

std::int64_t number_of(PgConnection& connection, const char* sql) {
  PgRows rows = connection.query(sql);
  return rows.next() ? rows.number(0) : 0;
}

// 0: a new database.
Result<std::int64_t> version_of(PgConnection& connection) {
  // Reads the catalog itself: to_regclass() may answer from a cache of before another process's migration.
  PgRows names = connection.query(
      "SELECT count(*) FILTER (WHERE tablename = 'meshgauge_schema'), count(*) FROM pg_tables WHERE schemaname = "
      "current_schema() AND tablename IN ('meshgauge_schema', 'jobs', 'meshes', 'stored', 'checks', 'batches', "
      "'batch_items', 'blobs', 'blob_chunks')");
  names.next();
  if (names.number(0) == 0) {
    if (names.number(1) != 0)
      return unusable_database(
          "is not one of meshgauge: it has tables of the same names; use another database or schema");
    return std::int64_t{0};
  }
  const std::int64_t version = number_of(connection, "SELECT version FROM meshgauge_schema");
  if (version == 0) return unusable_database("is damaged: its table meshgauge_schema has no version; restore a backup");
  return version;
}

Error written_later(std::int64_t version, std::size_t newest) {
  return unusable_database("was written by a later version of meshgauge (schema " + std::to_string(version) +
                           "; this one knows " + std::to_string(newest) +
                           "): run that version, or restore an older backup");
}

constexpr const char* kLockTimeout = "55P03";

bool is_about_rights(const PgFailure& failure) { return failure.state == "42501" || failure.state == "3F000"; }

std::string text_of(PgConnection& connection, const char* sql) {
  PgRows rows = connection.query(sql);
  return rows.next() ? rows.text(0) : "";
}

// The error for a role that lacks rights to read or change the tables. Precondition: no transaction is open.
Error lacks_rights(PgConnection& connection, const std::string& to_do, const std::string& remedy,
                   const PgFailure& failure) {
  const std::string role = text_of(connection, "SELECT current_user::text::bytea");
  return {ErrorCode::storage_unavailable,
          "the database's role '" + role + "' may not " + to_do + ": " + failure.message + ". " + remedy, "", ""};
}

Error may_not_read(PgConnection& connection, const PgFailure& failure) {
  return lacks_rights(
      connection, "use the tables of meshgauge",
      "Grant it SELECT, INSERT, UPDATE and DELETE on all of them, or connect as the role that owns them", failure);
}

Error may_not_change(PgConnection& connection, std::int64_t version, std::size_t newest, const PgFailure& failure) {
  const std::string schema = text_of(connection, "SELECT coalesce(current_schema(), '')::text::bytea");
  const std::string remedy =
      schema.empty() ? "No schema of its search_path exists: create one"
      : version == 0
          ? "Grant it CREATE on the schema '" + schema + "', or run `meshgauge migrate` as a role that has it"
          : "Run `meshgauge migrate` as the role that owns the tables in the schema '" + schema +
                "' and may create others there";
  return lacks_rights(connection,
                      "bring the schema from version " + std::to_string(version) + " to " + std::to_string(newest),
                      remedy, failure);
}

void take_steps(PgConnection& connection, std::int64_t version, std::span<const char* const> steps) {
  if (version == 0) {
    connection.execute(
        "CREATE TABLE meshgauge_schema (one boolean PRIMARY KEY DEFAULT true CHECK (one), version integer NOT NULL); "
        "INSERT INTO meshgauge_schema (version) VALUES (0)");
  }
  for (auto next = static_cast<std::size_t>(version); next < steps.size(); ++next) connection.execute(steps[next]);
  connection.query("UPDATE meshgauge_schema SET version = $1", steps.size());
}

Result<Migrated> migrate_alone(PgConnection& connection, std::span<const char* const> steps) {
  PgTransaction transaction(connection);
  // Waits as long as another process's migration takes.
  connection.execute("SET LOCAL lock_timeout = 0; SET LOCAL statement_timeout = 0");
  connection.query("SELECT pg_advisory_xact_lock($1)", kLock);
  const Result<std::int64_t> version = version_of(connection);
  if (!version) return version.error();
  const auto newest = static_cast<std::int64_t>(steps.size());
  if (*version > newest) return written_later(*version, steps.size());
  if (*version == newest) return Migrated{newest, newest};
  // While this waits for a table that is read (by a backup, for hours), all other sessions wait behind it.
  connection.execute("SET LOCAL lock_timeout = '1s'");
  take_steps(connection, *version, steps);
  transaction.commit();
  return Migrated{*version, newest};
}

}  // namespace

std::span<const char* const> pg_schema_steps() { return kSteps; }

Result<Migrated> pg_migrate(PgConnection& connection, std::span<const char* const> steps) {
  const auto newest = static_cast<std::int64_t>(steps.size());
  std::int64_t found = 0;
  try {
    // The common case, nothing to do, takes no lock.
    const Result<std::int64_t> version = version_of(connection);
    if (version && *version == newest) return Migrated{newest, newest};
    if (version) found = *version;
  } catch (const PgFailure& failure) {
    if (!is_about_rights(failure)) throw;
    return may_not_read(connection, failure);
  }
  while (true) {
    try {
      return migrate_alone(connection, steps);
    } catch (const PgFailure& failure) {
      if (is_about_rights(failure)) return may_not_change(connection, found, steps.size(), failure);
      if (failure.state != kLockTimeout) throw;
    }
    std::this_thread::sleep_for(kTables);
  }
}

}  // namespace meshgauge::server::store
