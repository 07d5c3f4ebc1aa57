// Jobs as rows of the table, and back.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

// The columns of a job, in the order that pg_job_of() reads them in.
#define MESHGAUGE_PG_JOB                                                                                     \
  "owner, id, state, mesh_a, mesh_b, hints, options, cost, idempotency_key, fingerprint, trace, created, "   \
  "expires_if_never_run, tries, worker, cancel_requested, started, finished, expires, lower, upper, stage, " \
  "document, problem, last_error, batch, deadline, verdict, excused, bounds_by"
inline constexpr int kPgJobColumns = 30;

// A job that is looked for by its key is found by the index of keys alone: `state + 0` is in no partial index.

// The end of a statement whose query `ended` has the columns owner and parent of jobs that it has ended: their wholes
// wait for one part less each. Wholes are locked after parts, everywhere.
#define MESHGAUGE_PG_SETTLE_WHOLES                                                                                \
  "settled AS (UPDATE jobs AS whole SET awaits = whole.awaits - part.number FROM (SELECT owner, parent, "         \
  "count(*)::int AS number FROM ended WHERE parent <> '' GROUP BY owner, parent ORDER BY owner, parent) AS part " \
  "WHERE whole.owner = part.owner AND whole.id = part.parent AND whole.state + 0 = 0 AND whole.awaits > 0) "

// In a statement whose query `touched` has number, owner, parent and state of the jobs that it has changed, and whose
// parameters are these times: of each part that it has ended as failed, nobody needs the others any more. The query
// `stopped` has owner, id and state of those others, `ended` is what MESHGAUGE_PG_SETTLE_WHOLES needs. A circle with
// somebody who locks the same parts in another order is broken by the database, and the call repeated.
#define MESHGAUGE_PG_STOP_OTHER_PARTS(now, keep_until)                                                               \
  "others AS MATERIALIZED (SELECT part.number FROM (SELECT DISTINCT owner, parent FROM touched WHERE state = 3 AND " \
  "parent <> '') AS given_up CROSS JOIN LATERAL (SELECT number FROM jobs WHERE jobs.owner = given_up.owner AND "     \
  "jobs.parent = given_up.parent AND jobs.parent <> '' AND state < 2 AND number <> ALL (ARRAY(SELECT number FROM "   \
  "touched)) ORDER BY id FOR NO KEY UPDATE) AS part), "                                                              \
  "stopped AS (UPDATE jobs SET cancel_requested = true, state = CASE state WHEN 0 THEN 4 ELSE 1 END, finished = "    \
  "CASE state WHEN 0 THEN " now " END, expires = CASE state WHEN 0 THEN " keep_until                                 \
  " END FROM others WHERE jobs.number = others.number RETURNING jobs.owner, jobs.id, jobs.parent, jobs.state), "     \
  "ended AS (SELECT owner, parent FROM touched WHERE state >= 2 UNION ALL SELECT owner, parent FROM stopped WHERE "  \
  "state >= 2), "

Job pg_job_of(const PgRows& row);
Token pg_token_of(const PgRows& row);

struct JobRow {
  Job job;
  std::string work;    // BatchItem::work
  std::string parent;  // id of the whole
  std::int64_t awaits = 0;
};

// Those that there are already, by id or by idempotency key, are left out; how many were not.
std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows);

std::optional<Job> pg_find_job(PgConnection& connection, const JobKey& key);
std::optional<Job> pg_find_idempotent_job(PgConnection& connection, const std::string& owner, const std::string& key);

}  // namespace meshgauge::server::store
