#include "server/store/job_rows.h"

#include "server/store/shares.h"

namespace meshgauge::server::store {
namespace {

std::optional<std::string> none_if_empty(const std::string& text) {
  if (text.empty()) return std::nullopt;
  return text;
}

struct HandedBack {
  JobState state;
  unsigned excused;
};

HandedBack after_try(bool cancel_requested, unsigned tries, unsigned excused, const std::string& last_error) {
  if (last_error.empty()) ++excused;
  if (cancel_requested) return {JobState::cancelled, excused};
  return {tries >= excused + kMaxTries ? JobState::failed : JobState::queued, excused};
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

std::optional<JobState> give_back(Connection& connection, const Token& token, const std::string& last_error,
                                  Moment moment) {
  Query row(connection,
            "SELECT cancel_requested, tries, excused FROM jobs WHERE owner = ? AND id = ? AND state = 1 AND worker = ? "
            "AND tries = ?",
            token.key.owner, token.key.id, token.worker, token.tries);
  if (!row.next()) return std::nullopt;
  const HandedBack back = after_try(row.number(0) != 0, static_cast<unsigned>(row.number(1)),
                                    static_cast<unsigned>(row.number(2)), last_error);
  const bool ended = has_ended(back.state);
  Query(connection,
        "UPDATE jobs SET state = ?, excused = ?, worker = '', lease_until = NULL, finished = ?, expires = ?, "
        "last_error = iif(? = '', last_error, ?) WHERE owner = ? AND id = ?",
        back.state, back.excused, ended ? std::optional(moment.now) : std::nullopt,
        ended ? std::optional(moment.keep_until) : std::nullopt, last_error, last_error, token.key.owner, token.key.id)
      .run();
  return back.state;
}

}  // namespace meshgauge::server::store
