// The jobs that must outlive a crash, and the results that are kept: what the service asks of a database.
//
//   queued --claim--> running --finish--> done | failed | cancelled --forget, sweep--> gone
//      ^                 |
//      +---hand_back-----+   (recover: the same for jobs whose worker is dead)
//
// Fencing: claim() hands out a token (worker, tries). Whatever a worker writes about its job names that token, and is
// stored only as long as it is the newest: a worker that was thought dead and comes back can change nothing.
//
// Every call is thread safe, and its effect is durable when it returns (record() and touch_mesh() say otherwise).
// Errors: ErrorCode::storage_full (no room; passes by itself when there is some), storage_unavailable (read-only,
// locked, I/O error: may pass), internal (damaged, or our own bug). After an error nothing of the call is stored,
// except that a failed commit may show up after a crash: all calls may be repeated with the same arguments.
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

// Milliseconds since 1970: what the database keeps, and what documents show.
using TimePoint = std::chrono::sys_time<std::chrono::milliseconds>;
inline TimePoint now() { return std::chrono::floor<std::chrono::milliseconds>(std::chrono::system_clock::now()); }

// Now, and until when a job is kept that the call ends.
struct Moment {
  TimePoint now;
  TimePoint keep_until;
};

// A job that was begun this often without an end is given up, because it is likely to be what kills its workers.
inline constexpr unsigned kMaxTries = 5;

// How often a job of a batch is excused that was lost with its worker before it told any progress (policy.h).
inline constexpr unsigned kMaxUnbegun = 2;

enum class JobState { queued, running, done, failed, cancelled };
inline bool has_ended(JobState state) { return state >= JobState::done; }

struct JobKey {
  std::string owner;  // "" when the service has no keys
  std::string id;     // nobody can guess it
  bool operator==(const JobKey&) const = default;
};

struct NewJob {
  JobKey key;
  std::string mesh_a, mesh_b;   // ids of blobs of the same owner
  std::string hints;            // JSON text that the store does not look into: file names, media types
  std::string options;          // likewise
  std::uint64_t cost = 0;       // bytes to read: what the order of claim_some() goes by
  std::string idempotency_key;  // empty: none. One job of an owner has it
  std::string fingerprint;      // of what was asked for; the same key with another one is a conflict
  std::string trace;            // traceparent, or empty
  std::string batch;            // id of the batch of the same owner that asked for it first; empty: none
  TimePoint created{};
  std::optional<TimePoint> deadline;  // by which it is to have ended: somebody waits for it. None: its time begins
                                      // with its run
  TimePoint expires_if_never_run{};   // sweep_jobs() fails it when it is still queued then
};

struct Progress {
  double lower = 0;
  double upper = 0;  // may be infinity
  std::string stage;
  std::string by{};  // the version of the engine that certified both bounds; empty: not known
  bool operator==(const Progress&) const = default;
};

// What is known of a job whose workers have told both, the stage of `newer`: of each bound the better one, if all are
// certified of the same quantity; else those of `newer`.
//
// They are, if the same engine certified them for the same job. The distance that a job asks for is a number: its
// meshes are named by their digests, and its hints and options, with the direction in them, are written once, with the
// job. A version of the program makes the same triangles of the same bytes; another one might not. With lower <= h <=
// upper of each of two intervals of one number h, max(lower) <= h <= min(upper): so no bound is better than one that
// was certified, and the interval never widens, whoever begins the job anew. That it would be empty is impossible then;
// if it should be, one of the two was wrong, and they are not mixed.
Progress narrowed(const std::optional<Progress>& known, const Progress& newer);

struct Job : NewJob {
  JobState state = JobState::queued;
  unsigned tries = 0;  // how often it was claimed
  bool cancel_requested = false;
  std::optional<TimePoint> started;   // of the newest try
  std::optional<TimePoint> finished;  // when it has ended
  std::optional<TimePoint> expires;   // likewise
  std::optional<Progress> progress;   // of all heartbeats, narrowed(); the stage is that of the newest of this try
  std::string document;               // JSON text: the result, or empty
  std::string problem;                // JSON text, or empty. A job given up by the store has last_error alone
  std::string last_error;             // why the newest try that failed did
  std::string verdict;                // of its gate, when it has ended: "pass", "fail", "undecided", or empty
  bool suspected = false;             // an earlier try was lost with its worker: perhaps it is what ends its workers
};

struct Token {
  JobKey key;
  std::string worker;
  unsigned tries = 0;
};

struct Claimed {
  Token token;
  Job job;  // as it is now: running
};

struct Inserted {
  Job job;                // the new one, or the one that was there
  bool existed = false;   // the idempotency key or the id is taken: nothing was stored
  bool conflict = false;  // ... by a job with another fingerprint
};

enum class Heartbeat {
  go_on,
  cancel,  // somebody asked for it: end soon, by finish()
  lost,    // the token is no longer the newest: end, nothing will be stored
};

struct Ending {
  JobState state = JobState::done;  // done, failed or cancelled
  std::string document;
  std::string problem;
  TimePoint finished{};
  TimePoint expires{};
  std::string verdict{};  // as in Job
  bool reusable = false;  // equal work would come to the same: it was not cut short by time or by anybody
  // As BatchItem::work, of what was done: a worker of another version than who asked does other work than was asked
  // for. None: what was asked for. Nothing becomes of it for a job that has no work.
  std::optional<std::string> work{};
};

struct Finished {
  Token token;
  Ending ending;
};

struct Beat {
  Token token;
  std::optional<Progress> progress;  // none: as it was
};

struct Counts {
  std::uint64_t queued = 0, running = 0, done = 0, failed = 0, cancelled = 0;
  std::uint64_t unrecorded = 0;       // given to record(), not yet durable
  std::uint64_t dropped_records = 0;  // ... and given up since the start, because there were too many of them
  std::uint64_t unawaited = 0;        // queued or running, in no batch, and without a deadline
  std::optional<TimePoint> oldest_queued;
};

struct SweptJobs {
  std::uint64_t expired = 0;   // ended, and their time was over
  std::uint64_t over_cap = 0;  // ended, the oldest beyond the number that is kept
  std::uint64_t given_up = 0;  // queued for too long: failed now
};

class JobStore {
 public:
  virtual ~JobStore() = default;

  virtual Result<Inserted> insert(const NewJob& job) = 0;

  // queued -> running, of up to `most` jobs. What earlier tries have told of the interval stays. First the owners with
  // the fewest running jobs; of an owner first what has the fewest running, each batch and all that is in none; of that
  // the smallest job, where each second of waiting outweighs kBytesOfOneSecond of size, so that none waits for ever.
  // More than one are of one batch, and together no larger than kBytesOfOneSecond; a job that is `suspected` comes
  // alone, or, when such are passed over, not at all. A crash may undo a claim: the job is queued then. It costs as
  // much as there are groups, and suspected jobs that are passed over.
  enum class Suspects { too, passed_over };
  virtual Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                                  std::size_t most, Suspects suspects = Suspects::too) = 0;
  static constexpr std::int64_t kBytesOfOneSecond = 50'000'000;

  // Of jobs of one worker, in the order given. Progress is stored as narrowed(). A crash may undo it.
  virtual Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) = 0;

  // running -> ended, all of them or (an Error) none. false, in the order given: the token is no longer the newest,
  // nothing is stored. True again when it is repeated.
  virtual Result<std::vector<bool>> finish_all(std::span<const Finished> endings) = 0;
  // running -> queued; -> failed after kMaxTries, without a problem but with `last_error`; -> cancelled when that was
  // asked for. With an empty `last_error` the job is not to blame (the service shuts down), and the try does not count
  // towards kMaxTries. Says the new state; nullopt: the token is no longer the newest.
  virtual Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error,
                                                    Moment moment) = 0;
  // queued -> cancelled at once; running: its next heartbeat says so. The state after it; nullopt: unknown.
  virtual Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) = 0;

  // Keeps a job that has ended and was never in the store. Returns at once; get() knows it from then on. It is
  // durable a little later, flush() waits for that. While nothing can be written the newest are held, the oldest
  // dropped.
  virtual void record(Job ended) = 0;
  // Until all that record() and touch_mesh() were given before is durable; the error that kept it from that.
  virtual Result<Done> flush() = 0;

  virtual Result<std::optional<Job>> get(const JobKey& key) = 0;
  // Those of the keys that there are, in no order. This one asks for each by itself.
  virtual Result<std::vector<Job>> get_many(std::span<const JobKey> keys);
  virtual Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& idempotency_key) = 0;
  // Ended jobs only. false: there is none of that key, or it has not ended.
  virtual Result<bool> forget(const JobKey& key) = 0;

  // Of nullopt, from time to time where several processes work on one store: running jobs whose lease is over are
  // handed back, with `why` as their last error. Else those whose worker's name starts with `dead_workers` ("" is the
  // start of every name), whatever their lease, and no others: only who is on duty takes from workers that may live.
  // What becomes of them is after_loss() of policy.h. Returns the jobs that are queued then and in no batch, oldest
  // first; nothing where other processes work on the store.
  virtual Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                           Moment moment) = 0;

  virtual Result<Counts> counts() = 0;
  // How many jobs of this owner wait or run, for the limit of a key: those in no batch, which nobody has asked to end
  // and whose deadline is not over. It costs as much as there are.
  virtual Result<std::uint64_t> unended(const std::string& owner, TimePoint now) = 0;
  // What jobs that have not ended and meshes refer to: BlobStore::remove_unused() must leave it. In no order, each
  // once.
  virtual Result<std::vector<BlobKey>> used_blobs() = 0;
  virtual Result<bool> uses_blob(const BlobKey& key) = 0;  // whether it is one of these
  // Removes ended jobs whose time is over, and beyond `max_kept` of them the oldest of each owner that has more than
  // its share: first of those given to record(), then of those that were promised to be kept.
  virtual Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) = 0;
  virtual Result<Done> check() = 0;  // that something can be written, by writing it

  // The clock of all who work on this store. Costs nothing, and needs no connection.
  virtual TimePoint time() const { return now(); }
  // Whether recover(nullopt, ...) and the sweeps are this process's to do: they are one process's at a time.
  virtual bool on_duty() { return true; }
};

}  // namespace meshgauge::server::store
