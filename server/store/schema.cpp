#include "server/store/schema.h"

#include <string>

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kApplication = 0x4d474a31;  // "MGJ1": marks our files among SQLite databases

constexpr const char* kSqliteFirst = R"sql(
CREATE TABLE jobs (
  number INTEGER PRIMARY KEY,
  owner TEXT NOT NULL,
  id TEXT NOT NULL,
  state INTEGER NOT NULL CHECK (state BETWEEN 0 AND 4),  -- JobState
  mesh_a TEXT NOT NULL,
  mesh_b TEXT NOT NULL,
  hints TEXT NOT NULL,
  options TEXT NOT NULL,
  cost INTEGER NOT NULL,
  rank INTEGER NOT NULL,                   -- order of claim_some(): see rank_of()
  idempotency_key TEXT,
  fingerprint TEXT NOT NULL,
  trace TEXT NOT NULL,
  created INTEGER NOT NULL,                -- times: milliseconds since 1970
  expires_if_never_run INTEGER NOT NULL,
  tries INTEGER NOT NULL DEFAULT 0,
  excused INTEGER NOT NULL DEFAULT 0,      -- tries that ended without the job's fault
  worker TEXT NOT NULL DEFAULT '',         -- with tries: the newest token
  lease_until INTEGER,
  cancel_requested INTEGER NOT NULL DEFAULT 0,
  started INTEGER,
  finished INTEGER,
  expires INTEGER,
  lower REAL,
  upper REAL,
  stage TEXT,
  document TEXT NOT NULL DEFAULT '',
  problem TEXT NOT NULL DEFAULT '',
  last_error TEXT NOT NULL DEFAULT '',
  CHECK ((state >= 2) = (finished IS NOT NULL AND expires IS NOT NULL)),
  UNIQUE (owner, id)
);
CREATE UNIQUE INDEX jobs_idempotent ON jobs (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE INDEX jobs_by_state ON jobs (state, owner);
CREATE INDEX jobs_waiting ON jobs (rank) WHERE state = 0;
CREATE INDEX jobs_expiring ON jobs (expires) WHERE state >= 2;
CREATE INDEX jobs_finished ON jobs (finished) WHERE state >= 2;

CREATE TABLE meshes (
  owner TEXT NOT NULL,
  id TEXT NOT NULL,
  bytes INTEGER NOT NULL,
  media_type TEXT NOT NULL,
  file_name TEXT NOT NULL,
  created INTEGER NOT NULL,
  last_used INTEGER NOT NULL,
  expires INTEGER NOT NULL,
  PRIMARY KEY (owner, id)
) WITHOUT ROWID;
CREATE INDEX meshes_expiring ON meshes (expires);

-- The sum of meshes.bytes of each owner, kept by the triggers.
CREATE TABLE stored (owner TEXT PRIMARY KEY, bytes INTEGER NOT NULL) WITHOUT ROWID;
CREATE TRIGGER mesh_added AFTER INSERT ON meshes BEGIN
  INSERT INTO stored VALUES (new.owner, new.bytes) ON CONFLICT (owner) DO UPDATE SET bytes = bytes + new.bytes;
END;
CREATE TRIGGER mesh_removed AFTER DELETE ON meshes BEGIN
  UPDATE stored SET bytes = bytes - old.bytes WHERE owner = old.owner;
  DELETE FROM stored WHERE owner = old.owner AND bytes = 0;
END;

CREATE TABLE checks (id INTEGER PRIMARY KEY CHECK (id = 1), at INTEGER NOT NULL);
)sql";

constexpr const char* kSqliteSecond = R"sql(
ALTER TABLE jobs ADD COLUMN batch TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN deadline INTEGER;
ALTER TABLE jobs ADD COLUMN verdict TEXT NOT NULL DEFAULT '';
ALTER TABLE jobs ADD COLUMN work TEXT NOT NULL DEFAULT '';         -- BatchItem::work
ALTER TABLE jobs ADD COLUMN reusable INTEGER NOT NULL DEFAULT 0;
ALTER TABLE jobs ADD COLUMN parent TEXT NOT NULL DEFAULT '';       -- id of the whole that it is a part of
ALTER TABLE jobs ADD COLUMN awaits INTEGER NOT NULL DEFAULT 0;     -- parts that have not ended
DROP INDEX jobs_waiting;
CREATE INDEX jobs_waiting ON jobs (owner, batch, rank) WHERE state = 0 AND awaits = 0;
CREATE INDEX jobs_running ON jobs (owner, batch) WHERE state = 1;
CREATE INDEX jobs_by_work ON jobs (owner, work) WHERE work != '';
CREATE INDEX jobs_by_parent ON jobs (owner, parent) WHERE parent != '';
CREATE INDEX jobs_using_a ON jobs (owner, mesh_a) WHERE state IN (0, 1);
CREATE INDEX jobs_using_b ON jobs (owner, mesh_b) WHERE state IN (0, 1);

CREATE TABLE batches (
  owner TEXT NOT NULL,
  id TEXT NOT NULL,
  name TEXT NOT NULL,
  idempotency_key TEXT,
  fingerprint TEXT NOT NULL,
  created INTEGER NOT NULL,
  cancel_requested INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (owner, id)
) WITHOUT ROWID;
CREATE UNIQUE INDEX batches_idempotent ON batches (owner, idempotency_key) WHERE idempotency_key IS NOT NULL;
CREATE TABLE batch_items (
  owner TEXT NOT NULL,
  batch TEXT NOT NULL,
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  job TEXT NOT NULL,                                               -- jobs.id
  PRIMARY KEY (owner, batch, position)
) WITHOUT ROWID;
CREATE INDEX batch_items_by_job ON batch_items (owner, job);
)sql";

constexpr const char* kSqliteThird = R"sql(
ALTER TABLE jobs ADD COLUMN bounds_by TEXT NOT NULL DEFAULT '';    -- Progress::by
-- One step from an owner that waits to the next. Only claim_some() uses it, by its last condition.
CREATE INDEX jobs_turns ON jobs (owner, rank) WHERE state = 0 AND awaits = 0 AND tries >= 0;
)sql";

constexpr const char* kSqliteFourth = R"sql(
-- The option "shards" asked for a comparison in parts; this store measured it in one piece.
UPDATE jobs SET options = json_remove(options, '$.shards')
  WHERE state IN (0, 1) AND instr(options, '"shards"') > 0 AND json_valid(options);
DROP INDEX jobs_by_parent;
DROP INDEX jobs_waiting;
DROP INDEX jobs_turns;
ALTER TABLE jobs DROP COLUMN parent;
ALTER TABLE jobs DROP COLUMN awaits;
CREATE INDEX jobs_waiting ON jobs (owner, batch, rank) WHERE state = 0;
CREATE INDEX jobs_turns ON jobs (owner, rank) WHERE state = 0 AND tries >= 0;
)sql";

constexpr const char* kSqliteFifth = R"sql(
CREATE TABLE origin (id INTEGER PRIMARY KEY CHECK (id = 1), born INTEGER NOT NULL, doubted INTEGER);  -- Origin
INSERT INTO origin SELECT 1, min(at), NULL FROM (
  SELECT created AS at FROM jobs UNION ALL SELECT created FROM meshes UNION ALL SELECT created FROM batches
  UNION ALL SELECT unixepoch() * 1000);

ALTER TABLE stored ADD COLUMN meshes INTEGER NOT NULL DEFAULT 0;  -- their number
UPDATE stored SET meshes = (SELECT count(*) FROM meshes WHERE meshes.owner = stored.owner);
DROP TRIGGER mesh_added;
DROP TRIGGER mesh_removed;
CREATE TRIGGER mesh_added AFTER INSERT ON meshes BEGIN
  INSERT INTO stored VALUES (new.owner, new.bytes, 1)
    ON CONFLICT (owner) DO UPDATE SET bytes = bytes + new.bytes, meshes = meshes + 1;
END;
CREATE TRIGGER mesh_removed AFTER DELETE ON meshes BEGIN
  UPDATE stored SET bytes = bytes - old.bytes, meshes = meshes - 1 WHERE owner = old.owner;
  DELETE FROM stored WHERE owner = old.owner AND meshes = 0;
END;
)sql";

constexpr const char* kSqliteSixth = R"sql(
ALTER TABLE jobs ADD COLUMN client TEXT NOT NULL DEFAULT '';       -- client_of() a job
UPDATE jobs SET client = owner WHERE state IN (0, 1) AND owner != '';
DROP INDEX jobs_turns;
DROP INDEX jobs_running;
CREATE INDEX jobs_turns ON jobs (client, rank) WHERE state = 0 AND tries >= 0;
CREATE INDEX jobs_of_client ON jobs (client, batch, rank) WHERE state = 0;
CREATE INDEX jobs_running ON jobs (client, batch) WHERE state = 1;
)sql";

// kGoesFirst of each owner.
constexpr const char* kSqliteSeventh = R"sql(
DROP INDEX jobs_finished;
CREATE INDEX jobs_finished ON jobs (owner, (worker <> '' OR tries <> 1), finished) WHERE state >= 2;
)sql";

// The order of Listings.
constexpr const char* kSqliteEighth = R"sql(
CREATE INDEX jobs_newest ON jobs (owner, created, id);
CREATE INDEX meshes_newest ON meshes (owner, created, id);
CREATE INDEX batches_newest ON batches (owner, created, id);
)sql";

constexpr const char* kSqliteSteps[] = {kSqliteFirst, kSqliteSecond, kSqliteThird,   kSqliteFourth,
                                        kSqliteFifth, kSqliteSixth,  kSqliteSeventh, kSqliteEighth};

Error unusable_file(const Connection& connection, const std::string& why) {
  return {ErrorCode::internal, with_path(connection.path()) + " " + why, "", ""};
}

Result<Done> recognise(Connection& connection, std::int64_t version, std::size_t newest) {
  const std::int64_t application = connection.pragma("application_id");
  const bool is_new = application == 0 && version == 0 && connection.pragma("schema_version") == 0;
  if (application != kApplication && !is_new)
    return unusable_file(connection, "is not one of meshgauge: choose another data folder");
  if (version > static_cast<std::int64_t>(newest)) {
    return unusable_file(connection, "was written by a later version of meshgauge (schema " + std::to_string(version) +
                                         "; this one knows " + std::to_string(newest) +
                                         "): run that version, or restore an older backup");
  }
  return Done{};
}

Result<Done> look_for_damage(Connection& connection) {
  Query query(connection, "PRAGMA quick_check(1)");
  if (query.next() && query.text(0) == "ok") return Done{};
  return unusable_file(connection, "is damaged: " + query.text(0));
}

void take_step(Connection& connection, std::size_t version, const char* step) {
  connection.execute("BEGIN IMMEDIATE");
  try {
    connection.execute(step);
    connection.execute(("PRAGMA application_id = " + std::to_string(kApplication)).c_str());
    connection.execute(("PRAGMA user_version = " + std::to_string(version + 1)).c_str());
    connection.execute("COMMIT");
  } catch (...) {
    if (connection.in_transaction()) connection.execute("ROLLBACK");
    throw;
  }
}

}  // namespace

std::span<const char* const> schema_steps() { return kSqliteSteps; }

Result<Migrated> migrate(Connection& connection, std::span<const char* const> steps) {
  try {
    const std::int64_t version = connection.pragma("user_version");
    Result<Done> sound = recognise(connection, version, steps.size());
    if (sound) sound = look_for_damage(connection);
    if (!sound) return sound.error();
    for (auto next = static_cast<std::size_t>(version); next < steps.size(); ++next) {
      take_step(connection, next, steps[next]);
    }
    return Migrated{version, static_cast<std::int64_t>(steps.size())};
  } catch (const SQLite::Exception& exception) {
    return connection.error_with_path(exception);
  }
}

}  // namespace meshgauge::server::store
