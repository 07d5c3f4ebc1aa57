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

Job pg_job_of(const PgRows& row);
Token pg_token_of(const PgRows& row);

struct JobRow {
  Job job;
  std::string work;  // BatchItem::work
};

// Those that there are already, by id or by idempotency key, are left out; how many were not.
std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows);

std::optional<Job> pg_find_job(PgConnection& connection, const JobKey& key);
std::optional<Job> pg_find_idempotent_job(PgConnection& connection, const std::string& owner, const std::string& key);

}  // namespace meshgauge::server::store
