// The transitions of a job, each once for both databases: its guard, a condition on a row of jobs, and its effect, the
// SET clause of an UPDATE. README.md has the table of states and events.
//
// `given` is a row of values that the statement joins to the job; other values are parameters with the numbers below.
// States are the numbers of JobState: 0 queued, 1 running, 2 done, 3 failed, 4 cancelled. `state + 0` matches no
// partial index, so PostgreSQL finds the row by its key.
#pragma once

#include "server/store/job_store.h"
#include "server/store/sql.h"

namespace meshgauge::server::store {

// queued -> running, by claim_some(). $1: whether suspected jobs are claimed too; $2 worker, $3 now, $4 lease_until.
inline constexpr Sql kClaimable("state = 0 AND (tries <= excused OR $1)");
inline constexpr Sql kClaim("state = 1, tries = tries + 1, worker = $2, started = $3, lease_until = $4, stage = NULL");

// The job runs under this token. `given`: the token.
inline constexpr Sql kHeld(R"sql(jobs.owner = given.owner AND jobs.id = given.id AND jobs.state + 0 = 1
        AND jobs.worker = given.worker AND jobs.tries = given.tries)sql");

// running -> running, by heartbeats(), where kHeld. Stores the bounds of narrowed(). `given`: lease_until, and lower,
// upper, stage and bounds_by, all NULL without progress.
inline constexpr Sql kNarrows(R"sql( AND jobs.bounds_by <> '' AND jobs.bounds_by = given.bounds_by
        AND jobs.lower <= given.upper AND given.lower <= jobs.upper)sql");
inline constexpr auto kRenew = R"sql(
      lease_until = given.lease_until,
      lower = CASE WHEN jobs.lower > given.lower)sql" +
                               kNarrows + R"sql( THEN jobs.lower ELSE coalesce(given.lower, jobs.lower) END,
      upper = CASE WHEN jobs.upper < given.upper)sql" +
                               kNarrows + R"sql( THEN jobs.upper ELSE coalesce(given.upper, jobs.upper) END,
      stage = coalesce(given.stage, jobs.stage),
      bounds_by = coalesce(given.bounds_by, jobs.bounds_by))sql";

// running -> done | failed | cancelled, by finish_all(). A repetition with the same token, state and time changes
// nothing and succeeds. `given`: the token, new_state, document, problem, verdict, finished, expires, reusable, and
// work or NULL.
inline constexpr Sql kEndable(R"sql(jobs.owner = given.owner AND jobs.id = given.id
        AND jobs.worker = given.worker AND jobs.tries = given.tries
        AND (jobs.state = 1 OR (jobs.state = given.new_state AND jobs.finished = given.finished)))sql");
inline constexpr Sql kEnd(R"sql(
      state = given.new_state, document = given.document, problem = given.problem, verdict = given.verdict,
      finished = given.finished, expires = given.expires, reusable = given.reusable <> 0, lease_until = NULL,
      work = CASE jobs.work WHEN '' THEN '' ELSE coalesce(given.work, jobs.work) END)sql");

// queued -> cancelled; running -> running, until its worker ends it: by request_cancel() and cancel_batch(). $3 now,
// $4 keep_until.
inline constexpr Sql kCancellable("state + 0 < 2");
inline constexpr Sql kCancel(R"sql(
      cancel_requested = true,
      state = CASE state WHEN 0 THEN 4 ELSE 1 END,
      finished = CASE state WHEN 0 THEN $3 END,
      expires = CASE state WHEN 0 THEN $4 END)sql");

// queued -> failed, by sweep_jobs(). $1 now, $2 keep_until.
inline constexpr Sql kNeverRun("state = 0 AND expires_if_never_run <= $1");
inline constexpr Sql kGiveUp(R"sql(
      state = 3, finished = $1, expires = $2,
      last_error = CASE last_error WHEN '' THEN 'no worker claimed it in time' ELSE last_error END)sql");

// ended -> gone, by sweep_jobs(). A job that an item of a batch points at stays as long as the batch. $1 now.
inline constexpr Sql kExpired(R"sql(state >= 2 AND expires <= $1
        AND NOT EXISTS (SELECT 1 FROM batch_items AS item WHERE item.owner = jobs.owner AND item.job = jobs.id))sql");

// The order in which ended jobs of one owner go that keeps too many: first those of record(), whose clients have had
// their answers, then the oldest. The index jobs_finished has it.
inline constexpr Sql kGoesFirst(" (worker <> '' OR tries <> 1), finished, number");

// A running job whose try ends without a result.
struct Loss {
  unsigned tries = 0;  // with this one
  unsigned excused = 0;
  bool cancel_requested = false;
  bool in_batch = false;
  bool told_progress = false;  // in this try
};

struct AfterLoss {
  JobState state = JobState::queued;
  unsigned excused = 0;
};

// running -> queued | failed | cancelled, when the worker hands the job back. An excused try does not count towards
// kMaxTries.
AfterLoss after_hand_back(const Loss& loss, bool excused);
// The same when the job is lost with its worker. Excuses a job of a batch that has told no progress, unless it is
// suspected or was excused kMaxUnbegun times: most likely it was one of many that were claimed at once, and another one
// ran.
AfterLoss after_loss(const Loss& loss);

// Rows whose worker is dead: by lease where $1 is NULL, else by the start of the worker's name. $2 now.
inline constexpr Sql kLost(R"sql(state = 1
        AND CASE WHEN $1 IS NULL THEN lease_until <= $2 ELSE substr(worker, 1, length($1)) = $1 END)sql");

// The last error of an excused try stays. $1 why, $2 now, $3 keep_until; `given`: AfterLoss.
inline constexpr Sql kHandBack(R"sql(
      state = given.state, excused = given.excused, worker = '', lease_until = NULL,
      finished = CASE WHEN given.state >= 2 THEN $2 END,
      expires = CASE WHEN given.state >= 2 THEN $3 END,
      last_error = CASE WHEN given.excused > jobs.excused THEN last_error ELSE $1 END)sql");

// A row that is to be handed back, and what becomes of it.
struct LostJob {
  std::int64_t number = 0;  // of the row
  JobKey key;
  Loss loss;
  AfterLoss after{};
};

inline constexpr Sql kLossColumns(R"sql(
      jobs.number, jobs.owner, jobs.id, jobs.tries, excused, cancel_requested, batch <> '', stage IS NOT NULL)sql");

// Makes jobs of rows of kLossColumns: `with_worker` by after_loss(), else by after_hand_back(). An empty `why` excuses
// each.
template <class Row>
std::vector<LostJob> lost_jobs(Row&& row, bool with_worker, const std::string& why) {
  std::vector<LostJob> all;
  while (row.next()) {
    const Loss loss{static_cast<unsigned>(row.number(3)), static_cast<unsigned>(row.number(4)), row.number(5) != 0,
                    row.number(6) != 0, row.number(7) != 0};
    const AfterLoss after = with_worker && !why.empty() ? after_loss(loss) : after_hand_back(loss, why.empty());
    all.push_back({row.number(0), {row.text(1), row.text(2)}, loss, after});
  }
  return all;
}

}  // namespace meshgauge::server::store
