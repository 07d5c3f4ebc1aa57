// The calls that both databases answer alike, by the statements of rows.h.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/store/batch_store.h"
#include "server/store/job_store.h"
#include "server/store/listings.h"
#include "server/store/mesh_index.h"
#include "server/store/rows.h"
#include "server/store/signals.h"
#include "server/store/write_behind.h"

namespace meshgauge::server::store {

// One database: all that it stores, and the signals of its changes.
class Database : public JobStore, public BatchStore, public MeshIndex, public Listings {
 public:
  virtual Signals& signals() = 0;
};

// `Self`: the store of one database, which derives from this class. Its `read(work)` returns the value of
// work(connection); its `try_writing(a_job)` is check() with a job or without; its `behind_` has what record() and
// touch_mesh() were given.
template <class Self>
class CommonStore : public Database {
 public:
  void record(Job ended) override { self().behind_.record(std::move(ended)); }
  Result<Done> flush() override { return self().behind_.flush(); }
  void touch_mesh(const BlobKey& key, TimePoint last_used, TimePoint expires) override {
    self().behind_.touch(key, {last_used, expires});
  }

  Result<std::optional<Job>> get(const JobKey& key) override {
    if (const auto job = self().behind_.find(key)) return std::optional<Job>(*job);
    return self().read([&](auto& db) { return find_job(db, key); });
  }
  Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& idempotency_key) override {
    return self().read([&](auto& db) { return find_idempotent_job(db, owner, idempotency_key); });
  }
  Result<Counts> counts() override {
    Result<Counts> counts = self().read([](auto& db) { return count_jobs(db); });
    if (counts) self().behind_.add_to(*counts);
    return counts;
  }
  Result<std::uint64_t> unended(const std::string& owner, TimePoint now) override {
    return self().read([&](auto& db) { return count_unended(db, owner, now); });
  }
  Result<bool> uses_blob(const BlobKey& key) override {
    return self().read([&](auto& db) { return db.query(kUsesBlob, key.owner, key.id).next(); });
  }
  Result<Origin> origin() override {
    return self().read([](auto& db) { return find_origin(db); });
  }
  Result<Done> check() override {
    const auto now = std::chrono::steady_clock::now();
    const bool a_job = now >= next_trial_.load();
    Result<Done> checked = self().try_writing(a_job);
    if (!checked) expect_failure();
    if (checked && a_job) next_trial_.store(now + kBetweenTrials);
    return checked;
  }

  Result<std::optional<Batch>> get_batch(const JobKey& key) override {
    return self().read([&](auto& db) { return batch_of(find_batch(db, key)); });
  }
  Result<std::optional<Batch>> find_idempotent_batch(const std::string& owner,
                                                     const std::string& idempotency_key) override {
    return self().read([&](auto& db) { return batch_of(store::find_idempotent_batch(db, owner, idempotency_key)); });
  }
  Result<std::vector<BatchRow>> batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                           std::size_t most) override {
    return self().read([&](auto& db) { return find_batch_rows(db, key, which, from, most); });
  }
  Result<Load> batch_load(const std::string& owner) override {
    return self().read([&](auto& db) { return count_batches(db, owner); });
  }

  Result<std::optional<MeshRow>> get_mesh(const BlobKey& key) override {
    return self().read([&](auto& db) { return find_mesh(db, key); });
  }
  Result<StoredMeshes> stored(const std::string& owner) override {
    return self().read([&](auto& db) { return find_stored(db, owner); });
  }
  Result<std::uint64_t> all_stored_bytes() override {
    return self().read([](auto& db) { return count_stored(db); });
  }

  Result<std::vector<MeshRow>> list_meshes(const Page& page) override {
    return self().read([&](auto& db) { return store::list_meshes(db, page); });
  }
  Result<std::vector<ListedJob>> list_jobs(const Page& page) override {
    return self().read([&](auto& db) { return store::list_jobs(db, page); });
  }
  Result<std::vector<ListedBatch>> list_batches(const Page& page) override {
    return self().read([&](auto& db) { return store::list_batches(db, page); });
  }
  Result<JobsOfOwner> jobs_owned(const std::string& owner) override {
    return self().read([&](auto& db) { return count_jobs_of(db, owner); });
  }
  Result<std::uint64_t> batches_owned(const std::string& owner) override {
    return self().read([&](auto& db) { return count_batches_of(db, owner); });
  }

 protected:
  void expect_failure() { next_trial_.store({}); }  // the next check() tries a job

 private:
  // Each trial leaves dead rows in PostgreSQL.
  static constexpr std::chrono::seconds kBetweenTrials{30};

  Self& self() { return static_cast<Self&>(*this); }

  std::atomic<std::chrono::steady_clock::time_point> next_trial_{};
};

}  // namespace meshgauge::server::store
