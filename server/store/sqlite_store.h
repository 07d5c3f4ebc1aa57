// JobStore, BatchStore, MeshIndex and Listings in one SQLite database: write-ahead log, synced at every commit, one
// writer (writer.h).
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "server/store/common_store.h"
#include "server/store/open_files.h"
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

class SqliteStore final : public CommonStore<SqliteStore> {
 public:
  // Creates the database if needed, and migrates an older schema. No other object may use the file (DataFolder ensures
  // that).
  static Result<std::unique_ptr<SqliteStore>> open(const SqliteSettings& settings);
  ~SqliteStore() override = default;  // writes what record() was given, if it can be written

  Signals& signals() override { return signals_; }

  Result<Inserted> insert(const NewJob& job) override;
  Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                          std::size_t most, Suspects suspects, Clients clients) override;
  Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) override;
  Result<std::vector<bool>> finish_all(std::span<const Finished> endings) override;
  Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error, Moment moment) override;
  Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) override;
  Result<bool> forget(const JobKey& key) override;
  Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                   Moment moment) override;
  Result<std::vector<BlobKey>> used_blobs() override;
  Result<std::vector<BlobKey>> known_blobs() override;
  Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) override;
  Result<Done> doubt(std::optional<TimePoint> since) override;

  Result<InsertedBatch> insert_batch(const NewBatch& batch) override;
  Result<bool> cancel_batch(const JobKey& key, Moment moment) override;
  Result<bool> forget_batch(const JobKey& key) override;
  Result<std::uint64_t> sweep_batches(TimePoint ended_before) override;

  Result<PutMesh> put_mesh(const MeshRow& row, const MeshQuota& quota) override;
  Result<bool> delete_mesh(const BlobKey& key) override;
  Result<std::vector<BlobKey>> sweep_meshes(TimePoint now) override;

 private:
  friend class CommonStore<SqliteStore>;

  SqliteStore(const SqliteSettings& settings, std::unique_ptr<Connection> connection);

  template <class Work>
  auto read(Work work) {
    return readers_.read(work);
  }
  Result<Done> cancel_the_rest(Moment moment);  // of batches whose cancelling was interrupted
  Result<Done> write(const WriteBehind::Batch& batch);
  Result<Done> try_writing(bool a_job);
  // Calls remove(most) until it removes fewer than the `most` that it may; returns their sum.
  Result<std::uint64_t> remove_in_portions(const std::function<Result<std::uint64_t>(std::int64_t most)>& remove);
  Result<std::uint64_t> remove_beyond_share(std::uint64_t max_kept, std::int64_t most);

  MemorySignals signals_;
  const OpenFiles files_;
  Readers readers_;
  Writer writer_;
  WriteBehind behind_;  // destroyed first: it writes until then
};

extern template class CommonStore<SqliteStore>;

// Inserts a job, for the jobs and the batches. `work`: BatchItem::work. false: there is a job of that id or that
// idempotency key already.
bool insert_row(Connection& connection, const Job& job, const std::string& work);

}  // namespace meshgauge::server::store
