#include "server/store/job_rows.h"

#include "server/store/policy.h"

namespace meshgauge::server::store {
namespace {

std::optional<std::string> none_if_empty(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return text;
}

}  // namespace

std::optional<Progress> progress_of(const Query& row, int column, int by) {
  if (row.is_null(column)) return std::nullopt;
  return Progress{row.real(column), row.real(column + 1), row.text(column + 2), row.text(by)};
}

Job job_of(const Query& row) {
  Job job;
  job.key = {row.text(0), row.text(1)};
  job.state = static_cast<JobState>(row.number(2));
  job.mesh_a = row.text(3);
  job.mesh_b = row.text(4);
  job.hints = row.text(5);
  job.options = row.text(6);
  job.cost = static_cast<std::uint64_t>(row.number(7));
  job.idempotency_key = row.text(8);
  job.fingerprint = row.text(9);
  job.trace = row.text(10);
  job.created = row.time(11);
  job.expires_if_never_run = row.time(12);
  job.tries = static_cast<unsigned>(row.number(13));
  job.cancel_requested = row.number(15) != 0;
  job.started = row.time_if_any(16);
  job.finished = row.time_if_any(17);
  job.expires = row.time_if_any(18);
  job.progress = progress_of(row, 19, 29);
  job.document = row.text(22);
  job.problem = row.text(23);
  job.last_error = row.text(24);
  job.batch = row.text(25);
  job.deadline = row.time_if_any(26);
  job.verdict = row.text(27);
  const bool trying = job.state == JobState::running;
  job.suspected = job.tries > row.number(28) + (trying ? 1 : 0);
  return job;
}

std::vector<JobKey> keys_of(Query& rows) {
  std::vector<JobKey> keys;
  while (rows.next()) keys.push_back({rows.text(0), rows.text(1)});
  return keys;
}

Token token_of(const Query& row) {
  return {{row.text(0), row.text(1)}, row.text(14), static_cast<unsigned>(row.number(13))};
}

bool insert_row(Connection& connection, const NewJob& job) {
  return Query(connection,
               "INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, "
               "fingerprint, trace, created, expires_if_never_run, batch, deadline) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, "
               "?, ?, ?, ?, ?, ?, ?) ON CONFLICT DO NOTHING",
               job.key.owner, job.key.id, JobState::queued, job.mesh_a, job.mesh_b, job.hints, job.options, job.cost,
               rank_of(job), none_if_empty(job.idempotency_key), job.fingerprint, job.trace, job.created,
               job.expires_if_never_run, job.batch, job.deadline)
             .run() == 1;
}

void insert_ended_row(Connection& connection, const Job& job) {
  const std::optional<Progress>& at = job.progress;
  Query(connection,
        "INSERT INTO jobs (rank, " MESHGAUGE_JOB_COLUMNS
        ") VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?) ON "
        "CONFLICT "
        "DO NOTHING",
        rank_of(job), job.key.owner, job.key.id, job.state, job.mesh_a, job.mesh_b, job.hints, job.options, job.cost,
        none_if_empty(job.idempotency_key), job.fingerprint, job.trace, job.created, job.expires_if_never_run,
        job.tries, std::string(), job.cancel_requested, job.started, job.finished, job.expires,
        at ? std::optional(at->lower) : std::nullopt, at ? std::optional(at->upper) : std::nullopt,
        at ? std::optional(at->stage) : std::nullopt, job.document, job.problem, job.last_error, job.batch,
        job.deadline, job.verdict, 0, at ? at->by : std::string())
      .run();
}

std::optional<Job> find_job(Connection& connection, const JobKey& key) {
  Query row(connection, "SELECT " MESHGAUGE_JOB_COLUMNS " FROM jobs WHERE owner = ? AND id = ?", key.owner, key.id);
  if (!row.next()) return std::nullopt;
  return job_of(row);
}

std::optional<Job> find_idempotent_job(Connection& connection, const std::string& owner, const std::string& key) {
  Query row(connection, "SELECT " MESHGAUGE_JOB_COLUMNS " FROM jobs WHERE owner = ? AND idempotency_key = ?", owner,
            key);
  if (!row.next()) return std::nullopt;
  return job_of(row);
}

}  // namespace meshgauge::server::store
