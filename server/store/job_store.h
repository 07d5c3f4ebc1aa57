// The store of jobs and results: those that must survive a crash, and those that are kept for their clients.
//
//   queued --claim--> running --finish--> done | failed | cancelled --forget, sweep--> gone
//      ^                 |
//      +---hand_back-----+   (recover: the same for jobs whose worker is dead)
//
// Fencing: a claim hands out a token (worker, tries). Every write of a worker names its token, and is stored only while
// the token is the newest: a worker that was taken for dead and comes back changes nothing. README.md has the table of
// states and events.
//
// All calls are thread safe, block for the disk or the database, and are durable when they return (record() and
// touch_mesh() say otherwise). Errors: storage_full (no room; passes when there is some), storage_unavailable
// (read-only, locked, unreachable, I/O error: may pass), internal (damaged, or our own bug). After an error nothing of
// the call is stored, except that a failed commit may show up after a crash. So any call may be repeated with the same
// arguments.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/store/blob_store.h"

namespace meshgauge::server::store {

// Milliseconds since 1970, as in the database and in documents.
using TimePoint = std::chrono::sys_time<std::chrono::milliseconds>;
inline TimePoint now() { return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

// The time of a call, and until when a job is kept that the call ends.
struct Moment {
  TimePoint now;
  TimePoint keep_until;
};

// Tries after which a job without an end has failed: it is likely to be what kills its workers.
inline constexpr unsigned kMaxTries = 5;

// How often a job of a batch is excused that was lost with its worker before it told any progress (after_loss()).
inline constexpr unsigned kMaxUnbegun = 2;

enum class JobState { queued, running, done, failed, cancelled };
std::string to_string(JobState state);  // "queued", as in documents
inline bool has_ended(JobState state) { return state >= JobState::done; }

struct JobKey {
  std::string owner;  // "" when the service has no keys
  std::string id;     // random, so that it cannot be guessed
  bool operator==(const JobKey&) const = default;
};

struct NewJob {
  JobKey key;
  std::string mesh_a, mesh_b;   // ids of blobs of the same owner
  std::string hints;            // JSON text, opaque to the store: file names, media types
  std::string options;          // JSON text, opaque to the store
  std::uint64_t cost = 0;       // bytes to read; claim_some() orders by it
  std::string idempotency_key;  // empty: none. At most one job of an owner has it
  std::string fingerprint;      // digest of meshes and options' text; another one with the same key is a conflict
  std::string trace;            // traceparent, or empty
  std::string batch;            // id of the batch of the same owner that created it; empty: none
  std::string client;           // in whose share it counts (claim_some()); empty: the owner
  TimePoint created{};
  std::optional<TimePoint> deadline;  // of a client that waits; nullopt: the job's time begins with its run
  TimePoint expires_if_never_run{};   // sweep_jobs() fails a job that is still queued then
};

inline const std::string& client_of(const NewJob& job) { return job.client.empty() ? job.key.owner : job.client; }

struct Progress {
  double lower = 0;
  double upper = 0;  // may be infinity
  std::string stage;
  std::string by{};  // version of the engine that certified both bounds; empty: unknown
  bool operator==(const Progress&) const = default;
};

// Returns the stage of `newer` with the better of each bound, if the same engine certified both intervals of the job
// and they overlap; else `newer`.
//
// Proof. The distance that a job asks for is one number h: its meshes are named by their digests, and its hints and
// options, with the direction in them, are written once, with the job. One version of the program reads the same
// triangles from the same bytes; another version might not. With lower <= h <= upper in each of two intervals,
// max(lower) <= h <= min(upper): so each bound was certified, and the interval never widens when another worker begins
// the job anew. The result cannot be empty then. If it is, one of the two was wrong, and they are not mixed.
Progress narrowed(const std::optional<Progress>& known, const Progress& newer);

struct Job : NewJob {
  JobState state = JobState::queued;
  unsigned tries = 0;  // number of claims
  bool cancel_requested = false;
  std::optional<TimePoint> started;   // of the newest try
  std::optional<TimePoint> finished;  // of an ended job
  std::optional<TimePoint> expires;   // of an ended job: until when it is kept
  std::optional<Progress> progress;   // narrowed() over all heartbeats; the stage of this try's newest
  std::string document;               // JSON text: the result, or empty
  std::string problem;                // JSON text, or empty. A job that the store failed has last_error alone
  std::string last_error;             // of the newest try that failed
  std::string verdict;                // of the gate of an ended job: "pass", "fail", "undecided", or empty
  bool suspected = false;             // an earlier try was lost with its worker: the job may be what ends workers
};

struct Token {
  JobKey key;
  std::string worker;
  unsigned tries = 0;
};

struct Claimed {
  Token token;
  Job job;  // running
};

struct Inserted {
  Job job;                // the new job, or the one that was there
  bool existed = false;   // a job has the id or the idempotency key: nothing was stored
  bool conflict = false;  // and its fingerprint is another one
};

enum class Heartbeat {
  go_on,
  cancel,  // a cancel was requested: end soon, by finish_all()
  lost,    // the token is no longer the newest: end; nothing will be stored
};

struct Ending {
  JobState state = JobState::done;  // done, failed or cancelled
  std::string document;
  std::string problem;
  TimePoint finished{};
  TimePoint expires{};
  std::string verdict{};  // as in Job
  bool reusable = false;  // equal work would have the same result: no timeout or cancel cut this job short
  // Deduplication key of the work that was done (BatchItem::work). It differs from the requested one when the worker
  // runs another version. nullopt: the requested one. Ignored for a job without a key.
  std::optional<std::string> work{};
};

struct Finished {
  Token token;
  Ending ending;
};

struct Beat {
  Token token;
  std::optional<Progress> progress;  // nullopt: unchanged
};

struct Counts {
  std::uint64_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;
  std::uint64_t unrecorded = 0;       // given to record(), not yet durable
  std::uint64_t dropped_records = 0;  // given to record() and dropped since the start: too many waited
  std::uint64_t unawaited = 0;        // queued or running, in no batch, without a deadline
  std::optional<TimePoint> oldest_queued;
};

struct SweptJobs {
  std::uint64_t expired = 0;   // removed: `expires` was over
  std::uint64_t over_cap = 0;  // removed: more than `max_kept`
  std::uint64_t given_up = 0;  // failed: queued until `expires_if_never_run`
};

// Where a database comes from: what it does not know may be older than itself.
struct Origin {
  TimePoint born;                    // not later than its first row
  std::optional<TimePoint> doubted;  // JobStore::doubt()
};

class JobStore {
 public:
  virtual ~JobStore() = default;

  // Stores a queued job, unless one has its id or its idempotency key (Inserted::existed).
  virtual Result<Inserted> insert(const NewJob& job) = 0;

  // Claims up to `most` queued jobs for the worker; empty: there is none, or other workers were faster. Concurrent
  // calls get different jobs. `worker` is best a name of this call alone: after an error recover() by that name hands
  // back what was claimed. Earlier tries' intervals stay. Several jobs of one claim are of one batch and together
  // cost at most kBytesOfOneSecond. A crash may undo a claim: the job is queued then.
  //
  // Order: the client with the fewest running jobs; of its batches, and its jobs of no batch as one group, the one with
  // the fewest running jobs; of that group the smallest job, where a second of waiting outweighs kBytesOfOneSecond, so
  // that no job waits for ever. The cost grows with the number of groups, not of jobs.
  //
  // A suspected job comes alone, or with `passed_over` not at all. `with_none_running`: clients that have a running
  // job are passed over.
  enum class Suspects { too, passed_over };
  enum class Clients { all, with_none_running };
  virtual Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                                  std::size_t most, Suspects suspects = Suspects::too,
                                                  Clients clients = Clients::all) = 0;
  static constexpr std::int64_t kBytesOfOneSecond = 50'000'000;

  // Renews the leases of jobs of one worker and stores their progress as narrowed(). Returns an answer for each beat,
  // in the order given. A crash may undo it.
  virtual Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) = 0;

  // Ends running jobs: all of them or, on an error, none. Returns for each, in the order given, whether it was stored;
  // false: the token is no longer the newest. A repetition returns true again.
  virtual Result<std::vector<bool>> finish_all(std::span<const Finished> endings) = 0;

  // Gives a running job back: queued again; failed with `last_error` after kMaxTries; cancelled if that was requested.
  // An empty `last_error` excuses the try (the service shuts down): it does not count towards kMaxTries. Returns the
  // new state; nullopt: the token is no longer the newest.
  virtual Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error,
                                                    Moment moment) = 0;

  // Cancels a queued job at once; a running one is cancelled by its worker, whose next heartbeat says so. Returns the
  // state afterwards; nullopt: there is no such job.
  virtual Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) = 0;

  // Keeps a job that has ended and was never in the store. Returns at once, and get() finds it from then on. It becomes
  // durable a little later (flush()). While nothing can be written the newest are held and the oldest dropped.
  virtual void record(Job ended) = 0;
  // Blocks until all that record() and touch_mesh() were given before is durable, or returns the error that prevents
  // it.
  virtual Result<Done> flush() = 0;

  virtual Result<std::optional<Job>> get(const JobKey& key) = 0;  // nullopt: there is no such job
  // Returns the jobs that exist, in no order.
  virtual Result<std::vector<Job>> get_many(std::span<const JobKey> keys);
  virtual Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& idempotency_key) = 0;
  // Removes an ended job. false: there is no such job, or it has not ended.
  virtual Result<bool> forget(const JobKey& key) = 0;

  // Requeues running jobs whose worker is dead, by after_loss(), with `why` as their last error. With nullopt those
  // whose lease has expired: call it periodically, while on_duty(). Else those whose worker's name starts with
  // `dead_workers` ("" starts every name), whatever their lease. Also finishes the cancelling of batches that was
  // interrupted. Returns the queued jobs of no batch, oldest first; nothing where other processes use the store.
  virtual Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                           Moment moment) = 0;

  virtual Result<Counts> counts() = 0;
  // Returns how many jobs of this owner count towards a key's limit: queued or running, in no batch, not to be
  // cancelled, with no deadline or one after `now`. The cost grows with that number.
  virtual Result<std::uint64_t> unended(const std::string& owner, TimePoint now) = 0;
  // Returns the blobs that meshes and unended jobs use, each once, in no order: BlobStore::remove_unused() must keep
  // them.
  virtual Result<std::vector<BlobKey>> used_blobs() = 0;
  // The same, and those of ended jobs, which need them no more. For rare questions: reads all rows.
  virtual Result<std::vector<BlobKey>> known_blobs() = 0;
  virtual Result<bool> uses_blob(const BlobKey& key) = 0;  // whether used_blobs() has it
  // Fails jobs that were queued for too long, removes ended jobs that have expired, and beyond `max_kept` ended jobs
  // the oldest of each owner that has more than its share: those of record() first.
  virtual Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) = 0;
  virtual Result<Origin> origin() = 0;
  // Keeps when a sweep found more unknown blobs than crashes leave; nullopt: it no longer does.
  virtual Result<Done> doubt(std::optional<TimePoint> since) = 0;
  // Whether a job could be stored now, and found by the next process. Looks at the jobs and writes something; the first
  // time, every half minute, and after a failure of this or of insert() it also writes a job, which it removes again.
  virtual Result<Done> check() = 0;

  // The clock of all processes that use this store. Never blocks.
  virtual TimePoint time() const { return now(); }
  // This time, for a call that keeps the jobs which it ends for `keep`.
  Moment moment(std::chrono::seconds keep) const {
    const TimePoint at = time();
    return {at, at + keep};
  }
  // Whether this process is the one that calls recover(nullopt, ...) and the sweeps. Never blocks.
  virtual bool on_duty() { return true; }
};

}  // namespace meshgauge::server::store
