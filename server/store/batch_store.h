// Batches: many comparisons of one owner that were asked for at once. In the same database as the jobs, with the same
// promises and errors (job_store.h).
//
// An item of a batch points at a job. Most jobs are the batch's own (Job::batch); equal work of one owner is one job,
// whichever batch or item asked for it first. Jobs that an item points at stay as long as the batch.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

struct BatchItem {
  std::string name;  // as its owner said
  NewJob job;        // key.owner and batch are those of the batch, the idempotency key is empty
  std::string work;  // the same for equal work: of both meshes, hints, options and version. Empty: never looked for.
                     // Who does it may say that he did another (Ending::work); it is found by that then
};

struct NewBatch {
  JobKey key;
  std::string name;
  std::string idempotency_key;  // empty: none. One batch of an owner has it; apart from those of jobs
  std::string fingerprint;
  TimePoint created{};
  std::vector<BatchItem> items;     // not empty
  std::vector<std::string> meshes;  // of this owner in the MeshIndex, each once, in order: they must be there
  bool repeats = false;  // its idempotency key was seen, so nothing was made ready for a new one: none is stored
};

// Of the jobs that the items point at: an item counts once, wherever else its job counts.
struct BatchCounts {
  std::uint64_t total = 0;
  std::uint64_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;
  std::uint64_t gone = 0;                           // ended, and not kept any more
  std::uint64_t pass = 0, fail = 0, undecided = 0;  // of those done that have a gate
};

struct Batch {
  JobKey key;
  std::string name;
  TimePoint created{};
  bool cancel_requested = false;
  std::optional<TimePoint> finished;  // of its last job, when all have ended
  std::optional<TimePoint> expires;   // likewise: until when it is kept
  BatchCounts counts;
};

struct InsertedBatch {
  Batch batch;             // the new one, or the one that was there
  bool existed = false;    // the idempotency key or the id is taken: nothing was stored
  bool conflict = false;   // ... by a batch with another fingerprint
  bool mesh_gone = false;  // one of NewBatch::meshes is not there: nothing was stored, and `batch` says nothing
  bool gone = false;       // what NewBatch::repeats is not there any more: likewise
};

struct BatchRow {
  std::uint64_t position = 0;  // in the manifest, from 0
  std::string name;
  std::optional<Job> job;  // none: it is not kept any more
};

class BatchStore {
 public:
  virtual ~BatchStore() = default;

  // All of it in one transaction, in which the meshes are looked up: so what refers to them is there before one of them
  // goes. Of each item whose work is that of a job of this owner that waits, runs, or has ended
  // reusable and is kept, the job is that one, and so it is for items of one batch among themselves.
  virtual Result<InsertedBatch> insert_batch(const NewBatch& batch) = 0;
  virtual Result<std::optional<Batch>> get_batch(const JobKey& key) = 0;  // nullopt: unknown
  virtual Result<std::optional<Batch>> find_idempotent_batch(const std::string& owner,
                                                             const std::string& idempotency_key) = 0;

  enum class Rows {
    ended,          // in the order of their positions
    failures_first  // ended and not passed: verdict fail, then failed, undecided, cancelled; then by position
  };
  // At most `most`, of those with positions from `from` on; with failures_first `from` is 0.
  virtual Result<std::vector<BatchRow>> batch_rows(const JobKey& key, Rows which, std::uint64_t from,
                                                   std::size_t most) = 0;

  // Its jobs that no other batch that is still wanted points at and nobody asked for by themselves: queued -> cancelled
  // at once; of running ones the next heartbeat says so. false: unknown. Promised once, it is done in portions that
  // hold up nobody; what a process that dies, or another one's locks, leave of it is done by JobStore::recover().
  virtual Result<bool> cancel_batch(const JobKey& key, Moment moment) = 0;
  // Of one whose jobs have all ended, and its jobs with it, as far as no other batch points at them. false: there is
  // none of that key, or it has not ended.
  virtual Result<bool> forget_batch(const JobKey& key) = 0;
  struct Load {
    std::uint64_t jobs = 0;     // of batches, that have not ended
    std::uint64_t batches = 0;  // that have such jobs of their own
  };
  virtual Result<Load> batch_load(const std::string& owner) = 0;
  // Forgets those whose last job ended before `ended_before`; how many.
  virtual Result<std::uint64_t> sweep_batches(TimePoint ended_before) = 0;
};

}  // namespace meshgauge::server::store
