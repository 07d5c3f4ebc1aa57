#include "server/store/schema.h"

#include <string>

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kApplication = 0x4d474a31;  // "MGJ1": tells our files from other SQLite databases

constexpr const char* kFirst = R"sql(
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
  rank INTEGER NOT NULL,                   -- order of claim_next(): see rank_of()
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

constexpr const char* kSteps[] = {kFirst};

Error refused(const Connection& connection, const std::string& why) {
  return {ErrorCode::internal, "the database '" + connection.path() + "' " + why, "", ""};
}

Result<Done> recognise(Connection& connection, std::int64_t version, std::size_t newest) {
  const std::int64_t application = connection.pragma("application_id");
  const bool is_new = application == 0 && version == 0 && connection.pragma("schema_version") == 0;
  if (application != kApplication && !is_new) return refused(connection, "is not one of meshgauge");
  if (version > static_cast<std::int64_t>(newest)) {
    return refused(connection, "was written by a later version of meshgauge (schema " + std::to_string(version) +
                                   "; this one knows " + std::to_string(newest) + ")");
  }
  return Done{};
}

Result<Done> look_for_damage(Connection& connection) {
  Query query(connection, "PRAGMA quick_check(1)");
  if (query.next() && query.text(0) == "ok") return Done{};
  return refused(connection, "is damaged: " + query.text(0));
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

std::span<const char* const> schema_steps() { return kSteps; }

Result<Done> migrate(Connection& connection, std::span<const char* const> steps) {
  try {
    const std::int64_t version = connection.pragma("user_version");
    Result<Done> sound = recognise(connection, version, steps.size());
    if (sound) sound = look_for_damage(connection);
    if (!sound) return sound;
    for (auto next = static_cast<std::size_t>(version); next < steps.size(); ++next) {
      take_step(connection, next, steps[next]);
    }
    return Done{};
  } catch (const SQLite::Exception& exception) {
    return connection.to_error(exception);
  }
}

}  // namespace meshgauge::server::store
