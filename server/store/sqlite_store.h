// JobStore, BatchStore, MeshIndex and Listings in one SQLite database: write-ahead log, synced at every commit, one
// writer (writer.h).
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/store/batch_store.h"
#include "server/store/job_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/outage.h"
#include "server/store/reserve.h"
#include "server/store/signals.h"
#include "server/store/sqlite.h"
#include "server/store/write_behind.h"
#include "server/store/writer.h"

namespace meshgauge::server::store {

struct SqliteSettings {
  std::string path;
  std::size_t max_unrecorded = 10'000;  // the most records that are held while they cannot be written
  Reserve* reserve = nullptr;           // borrowed; null: removals have no room of their own
  Report report = {};                   // gets a line when an older schema was migrated
};

class SqliteStore final : public JobStore, public BatchStore, public MeshIndex, public Listings {
 public:
  // Creates the database if needed, and migrates an older schema. No other object may use the file (DataFolder ensures
  // that).
  static Result<std::unique_ptr<SqliteStore>> open(const SqliteSettings& settings);
  ~SqliteStore() override = default;  // writes what record() was given, if it can be written

  Signals& signals() { return signals_; }

  Result<Inserted> insert(const NewJob& job) override;
  Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                          std::size_t most, Suspects suspects, Clients clients) override;
  Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) override;
  Result<std::vector<bool>> finish_all(std::span<const Finished> endings) override;
  Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error, Moment moment) override;
  Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) override;
  void record(Job ended) override { behind_.record(std::move(ended)); }
  Result<Done> flush() override { return behind_.flush(); }
  Result<std::optional<Job>> get(const JobKey& key) override;
  Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& idempotency_key) override;
  Result<bool> forget(const JobKey& key) override;
  Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                   Moment moment) override;
  Result<Counts> counts() override;
  Result<std::uint64_t> unended(const std::string& owner, TimePoint now) override;
  Result<std::vector<BlobKey>> used_blobs() override;
  Result<std::vector<BlobKey>> known_blobs() override;
  Result<bool> uses_blob(const BlobKey& key) override;
  Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) override;
  Result<Origin> origin() override;
  Result<Done> doubt(std::optional<TimePoint> since) override;
  Result<Done> check() override;

  Result<InsertedBatch> insert_batch(const NewBatch& batch) override;
  Result<std::optional<Batch>> get_batch(const JobKey& key) override;
  Result<std::optional<Batch>> find_idempotent_batch(const std::string& owner,
                                                     const std::string& idempotency_key) override;
  Result<std::vector<BatchRow>> batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                           std::size_t most) override;
  Result<bool> cancel_batch(const JobKey& key, Moment moment) override;
  Result<Load> batch_load(const std::string& owner) override;
  Result<bool> forget_batch(const JobKey& key) override;
  Result<std::uint64_t> sweep_batches(TimePoint ended_before) override;

  Result<PutMesh> put_mesh(const MeshRow& row, const MeshQuota& quota) override;
  Result<std::optional<MeshRow>> get_mesh(const BlobKey& key) override;
  void touch_mesh(const BlobKey& key, TimePoint last_used, TimePoint expires) override {
    behind_.touch(key, {last_used, expires});
  }
  Result<bool> delete_mesh(const BlobKey& key) override;
  Result<StoredMeshes> stored(const std::string& owner) override;
  Result<std::uint64_t> all_stored_bytes() override;
  Result<std::vector<BlobKey>> sweep_meshes(TimePoint now) override;

  Result<std::vector<MeshRow>> list_meshes(const Page& page) override;
  Result<std::vector<ListedJob>> list_jobs(const Page& page) override;
  Result<std::vector<ListedBatch>> list_batches(const Page& page) override;
  Result<JobsOfOwner> jobs_owned(const std::string& owner) override;
  Result<std::uint64_t> batches_owned(const std::string& owner) override;

 private:
  SqliteStore(const SqliteSettings& settings, std::unique_ptr<Connection> connection);

  Result<Done> cancel_the_rest(Moment moment);  // of batches whose cancelling was interrupted
  Result<Done> write(const WriteBehind::Batch& batch);
  // Calls remove(most) until it removes fewer than the `most` that it may; returns their sum.
  Result<std::uint64_t> remove_in_portions(const std::function<Result<std::uint64_t>(std::int64_t most)>& remove);
  Result<std::uint64_t> remove_beyond_share(std::uint64_t max_kept, std::int64_t most);

  MemorySignals signals_;
  Readers readers_;
  Writer writer_;
  WriteBehind behind_;  // destroyed first: it writes until then
};

// Inserts a queued job, for the jobs and the batches. `work`: BatchItem::work. false: there is a job of that id or that
// idempotency key already.
bool insert_row(Connection& connection, const NewJob& job, const std::string& work);

}  // namespace meshgauge::server::store
