// Batches: many comparisons of one owner in one request. They are in the same database as the jobs, with the same
// guarantees and errors (job_store.h).
//
// An item of a batch points at a job. Most jobs are the batch's own (Job::batch). Equal work of one owner is one job,
// which items of several batches may point at. A job that an item points at stays as long as the batch.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct BatchItem {
  std::string name;  // as given by the owner
  NewJob job;        // key.owner and batch are those of the batch, the idempotency key is empty
  std::string work;  // deduplication key, of both meshes, hints, options and version; empty: never deduplicated.
                     // Ending::work may replace it
};

struct NewBatch {
  JobKey key;
  std::string name;
  std::string idempotency_key;  // empty: none. At most one batch of an owner has it; jobs have keys of their own
  std::string fingerprint;
  TimePoint created{};
  std::vector<BatchItem> items;     // not empty
  std::vector<std::string> meshes;  // ids in the owner's MeshIndex, each once, sorted: they must exist
  bool repeats =
      false;  // the caller has seen the idempotency key, so nothing is prepared for a new batch: none is stored
};

// Counts of the items of a batch, by the state of their jobs.
struct BatchCounts {
  std::uint64_t total = 0;
  std::uint64_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;
  std::uint64_t gone = 0;                           // ended, and no longer kept
  std::uint64_t pass = 0, fail = 0, undecided = 0;  // verdicts of those that are done
};

struct Batch {
  JobKey key;
  std::string name;
  TimePoint created{};
  bool cancel_requested = false;
  std::optional<TimePoint> finished;  // when its last job ended; nullopt: some have not ended
  std::optional<TimePoint> expires;   // until when it is kept; nullopt: some have not ended
  BatchCounts counts;
};

struct InsertedBatch {
  Batch batch;             // the new batch, or the one that was there
  bool existed = false;    // a batch has the id or the idempotency key: nothing was stored
  bool conflict = false;   // and its fingerprint is another one
  bool mesh_gone = false;  // one of NewBatch::meshes does not exist: nothing was stored, `batch` is empty
  bool gone = false;       // NewBatch::repeats, and that batch no longer exists: nothing was stored, `batch` is empty
};

struct BatchRow {
  std::uint64_t position = 0;  // in the manifest, from 0
  std::string name;
  std::optional<Job> job;  // nullopt: no longer kept
};

class BatchStore {
 public:
  virtual ~BatchStore() = default;

  // Stores batch, items and jobs in one transaction. The transaction also looks up the meshes, so no mesh goes before
  // the rows that refer to it exist. An item shares the job of equal work: of another item, or of a job of this owner
  // that is queued, runs without a requested cancel, or has ended reusable.
  virtual Result<InsertedBatch> insert_batch(const NewBatch& batch) = 0;
  virtual Result<std::optional<Batch>> get_batch(const JobKey& key) = 0;  // nullopt: unknown
  virtual Result<std::optional<Batch>> find_idempotent_batch(const std::string& owner,
                                                             const std::string& idempotency_key) = 0;

  enum class Rows {
    ended,           // by position
    failures_first,  // not passed: verdict fail, then failed, then undecided, then cancelled; each by position
    running          // by position
  };
  // Returns at most `most` items, with positions from `from` on. Precondition: with failures_first `from` is 0.
  virtual Result<std::vector<BatchRow>> batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                                   std::size_t most) = 0;

  // Cancels the batch and those of its jobs that no batch which is not cancelled points at, as request_cancel() does;
  // jobs of no batch stay. false: there is no such batch. Works in short transactions; JobStore::recover() finishes
  // what a crash or another process's locks interrupt.
  virtual Result<bool> cancel_batch(const JobKey& key, Moment moment) = 0;
  // Removes a batch whose jobs have all ended, and its jobs unless another batch points at them. false: there is no
  // such batch, or it has not ended.
  virtual Result<bool> forget_batch(const JobKey& key) = 0;
  struct Load {
    std::uint64_t jobs = 0;     // queued or running, of batches
    std::uint64_t batches = 0;  // with such jobs of their own
  };
  virtual Result<Load> batch_load(const std::string& owner) = 0;
  // Removes batches whose last job ended before `ended_before`; returns their number.
  virtual Result<std::uint64_t> sweep_batches(TimePoint ended_before) = 0;
};

}  // namespace meshgauge::server::store
