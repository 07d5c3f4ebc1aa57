// JobStore, MeshIndex, BatchStore and Listings in one PostgreSQL database, for any number of processes at once.
//
// Each call is one statement or one transaction, repeated until its answer is known, for some seconds at most (pool.h).
// Rows of jobs are locked in the order of (owner, id), so that calls cannot deadlock.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "server/store/common_store.h"
#include "server/store/migrated.h"
#include "server/store/postgres/control.h"
#include "server/store/postgres/pool.h"
#include "server/store/write_behind.h"

namespace meshgauge::server::store {

struct PostgresSettings {
  std::string database;                          // connection string; several hosts are tried in turn
  std::size_t max_connections = 8;               // beside the one of PgControl
  std::chrono::milliseconds call_timeout{4000};  // of a call while the database does not answer
  std::chrono::milliseconds duty_grace{15'000};  // as in ControlSettings
  std::size_t max_unrecorded = 10'000;           // records that are held while they cannot be written
  Report report = {};                            // gets lines about outages
};

class PostgresStore final : public CommonStore<PostgresStore> {
 public:
  // Migrates the schema first if needed; the report gets a line about that.
  static Result<std::unique_ptr<PostgresStore>> open(const PostgresSettings& settings);
  ~PostgresStore() override = default;  // writes what record() was given, if it can be written

  Signals& signals() override { return control_; }
  PgPool& pool() { return pool_; }

  Result<Inserted> insert(const NewJob& job) override;
  Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                          std::size_t most, Suspects suspects, Clients clients) override;
  Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) override;
  Result<std::vector<bool>> finish_all(std::span<const Finished> endings) override;
  Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error, Moment moment) override;
  Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) override;
  Result<std::vector<Job>> get_many(std::span<const JobKey> keys) override;
  Result<bool> forget(const JobKey& key) override;
  Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                   Moment moment) override;
  Result<std::vector<BlobKey>> used_blobs() override;
  Result<std::vector<BlobKey>> known_blobs() override;
  Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) override;
  Result<Done> doubt(std::optional<TimePoint> since) override;
  TimePoint time() const override { return control_.time(); }
  bool on_duty() override { return control_.on_duty(); }

  Result<PutMesh> put_mesh(const MeshRow& row, const MeshQuota& quota) override;
  Result<std::vector<MeshRow>> known_meshes(const std::string& owner, std::span<const std::string> ids) override;
  Result<bool> delete_mesh(const BlobKey& key) override;
  Result<std::vector<BlobKey>> sweep_meshes(TimePoint now) override;

  Result<InsertedBatch> insert_batch(const NewBatch& batch) override;
  Result<bool> cancel_batch(const JobKey& key, Moment moment) override;
  Result<bool> forget_batch(const JobKey& key) override;
  Result<std::uint64_t> sweep_batches(TimePoint ended_before) override;

 private:
  friend class CommonStore<PostgresStore>;

  PostgresStore(const PostgresSettings& settings, std::int64_t time_offset_ns);

  template <class Work>
  auto read(Work work) {
    return pool_.run(Promise::fleeting, work);
  }
  Result<Done> write(const WriteBehind::Batch& batch);
  Result<Done> try_writing(bool a_job);
  void tell_handed_back(const JobKey& key, JobState state, bool in_batch);
  Result<std::uint64_t> remove_in_portions(
      const std::function<std::uint64_t(PgConnection&, std::int64_t most)>& remove);
  Result<Done> cancel_jobs_of(const JobKey& key, std::uint64_t items, Moment moment);
  Result<Done> cancel_the_rest(Moment moment);  // of batches whose cancelling was interrupted

  PgPool pool_;
  PgControl control_;
  WriteBehind behind_;  // destroyed first: it writes until then
};

extern template class CommonStore<PostgresStore>;

// `meshgauge migrate`: migrates the database to this version's schema.
Result<Migrated> migrate_database(const std::string& database);

// A row of jobs to insert.
struct JobRow {
  Job job;
  std::string work;  // BatchItem::work
};
// Inserts jobs as rows, for the jobs and the batches. Skips jobs whose id or idempotency key exists already; returns
// the number of inserted rows.
std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows);

}  // namespace meshgauge::server::store
