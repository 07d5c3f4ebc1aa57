#include "server/store/job_rows.h"

#include "server/store/rows.h"

namespace meshgauge::server::store {
namespace {

constexpr auto kInsertEnded = "INSERT INTO jobs (" + kJobColumns + R"sql(, rank)
    VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20, $21, $22, $23,
      $24, $25, $26, $27, $28, $29, $30, $31, $32)
    ON CONFLICT DO NOTHING)sql";

}  // namespace

bool insert_row(Connection& connection, const NewJob& job, const std::string& work) {
  return connection
             .query(R"sql(
    INSERT INTO jobs (owner, id, state, mesh_a, mesh_b, hints, options, cost, rank, idempotency_key, fingerprint, trace,
      created, expires_if_never_run, batch, deadline, work, client)
    VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18)
    ON CONFLICT DO NOTHING)sql",
                    job.key.owner, job.key.id, JobState::queued, job.mesh_a, job.mesh_b, job.hints, job.options,
                    job.cost, rank_of(job), none_if_empty(job.idempotency_key), job.fingerprint, job.trace, job.created,
                    job.expires_if_never_run, job.batch, job.deadline, work, client_of(job))
             .run() == 1;
}

void insert_ended_row(Connection& connection, const Job& job) {
  const std::optional<Progress>& at = job.progress;
  connection
      .query(kInsertEnded, job.key.owner, job.key.id, job.state, job.mesh_a, job.mesh_b, job.hints, job.options,
             job.cost, none_if_empty(job.idempotency_key), job.fingerprint, job.trace, job.created,
             job.expires_if_never_run, job.tries, std::string(), job.cancel_requested, job.started, job.finished,
             job.expires, at ? std::optional(at->lower) : std::nullopt, at ? std::optional(at->upper) : std::nullopt,
             at ? std::optional(at->stage) : std::nullopt, job.document, job.problem, job.last_error, job.batch,
             job.deadline, job.verdict, 0, at ? at->by : std::string(), client_of(job), rank_of(job))
      .run();
}

void use_mesh(Connection& connection, const BlobKey& key, TimePoint last_used, TimePoint expires) {
  connection
      .query(
          "UPDATE meshes SET last_used = max(last_used, $3), expires = max(expires, $4) WHERE owner = $1 AND id = $2",
          key.owner, key.id, last_used, expires)
      .run();
}

}  // namespace meshgauge::server::store
