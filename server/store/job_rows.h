// Jobs as rows of the table, and back.
#pragma once

#include <cstdint>

#include "server/store/sqlite.h"

namespace meshgauge::server::store {

// The columns of a job, in the order that job_of() reads them in.
#define MESHGAUGE_JOB_COLUMNS                                                                                \
  "owner, id, state, mesh_a, mesh_b, hints, options, cost, idempotency_key, fingerprint, trace, created, "   \
  "expires_if_never_run, tries, worker, cancel_requested, started, finished, expires, lower, upper, stage, " \
  "document, problem, last_error, batch, deadline, verdict, excused, bounds_by"
inline constexpr int kJobColumns = 30;

// Of the columns lower, upper and stage from `column` on, and bounds_by.
std::optional<Progress> progress_of(const Query& row, int column, int by);
Job job_of(const Query& row);
std::vector<JobKey> keys_of(Query& rows);  // of the columns owner and id, the first two
Token token_of(const Query& row);

// false: there is one of that id or that idempotency key already.
bool insert_row(Connection& connection, const NewJob& job);
void insert_ended_row(Connection& connection, const Job& job);  // likewise left out when there is one

std::optional<Job> find_job(Connection& connection, const JobKey& key);
std::optional<Job> find_idempotent_job(Connection& connection, const std::string& owner, const std::string& key);

}  // namespace meshgauge::server::store
