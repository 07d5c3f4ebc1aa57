#include "server/store/sqlite_store.h"

#include <fcntl.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <map>
#include <tuple>
#include <utility>

#include "server/store/errors.h"
#include "server/store/job_rows.h"
#include "server/store/schema.h"

namespace meshgauge::server::store {
namespace {

// SQLite would make the file readable to everybody; its log and index get the mode that it has.
Result<Done> make_private_file(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!file) return storage_error(errno, "the database '" + path + "' cannot be opened");
  return Done{};
}

Result<std::unique_ptr<Connection>> connect(const std::string& path) {
  errno = 0;
  try {
    return std::make_unique<Connection>(path, Connection::Use::write);
  } catch (const SQLite::Exception& exception) {
    return to_error(exception, path, errno);
  }
}

Job as_queued(const NewJob& job) {
  Job queued;
  static_cast<NewJob&>(queued) = job;
  return queued;
}

// What waits, by the name of its owner or its batch: the rank of its first job, and how many of it run.
struct Waiting {
  std::int64_t rank = 0;
  std::int64_t running = 0;
};
using AllWaiting = std::map<std::string, Waiting>;

// The fewest running first, then the first rank. Null: nothing waits.
const std::string* whose_turn(const AllWaiting& all) {
  const auto turn = [](const auto& one) { return std::tuple(one.second.running, one.second.rank); };
  const auto first =
      std::min_element(all.begin(), all.end(), [&](const auto& x, const auto& y) { return turn(x) < turn(y); });
  return first == all.end() ? nullptr : &first->first;
}

// Of rows of a name and a number: how many run.
void add_running(AllWaiting& all, Query&& row) {
  while (row.next()) {
    if (const auto found = all.find(row.text(0)); found != all.end()) found->second.running = row.number(1);
  }
}

// What claim_some() may take. The parameter: whether suspected jobs.
#define MESHGAUGE_CLAIMABLE "state = 0 AND (tries <= excused OR ?) "

// From one owner to the next by the index: their jobs may be many, they are few. `tries >= 0` is there for that index.
AllWaiting waiting_owners(Connection& connection, bool suspects) {
  AllWaiting owners;
  const auto add = [&](Query&& row) {
    return row.next() ? &*owners.emplace(row.text(0), Waiting{row.number(1)}).first : nullptr;
  };
  const auto* at =
      add(Query(connection,
                "SELECT owner, rank FROM jobs INDEXED BY jobs_turns WHERE tries >= 0 AND " MESHGAUGE_CLAIMABLE
                "ORDER BY owner, rank LIMIT 1",
                suspects));
  while (at) {
    at = add(Query(connection,
                   "SELECT owner, rank FROM jobs INDEXED BY jobs_turns WHERE tries >= 0 AND " MESHGAUGE_CLAIMABLE
                   "AND owner > ? ORDER BY owner, rank LIMIT 1",
                   suspects, at->first));
  }
  add_running(owners, Query(connection,
                            "SELECT owner, count(*) FROM jobs INDEXED BY jobs_running WHERE state = 1 GROUP BY owner"));
  return owners;
}

// Likewise the batches of an owner; "" is what is in none.
AllWaiting waiting_batches(Connection& connection, const std::string& owner, bool suspects) {
  AllWaiting batches;
  const auto add = [&](Query&& row) {
    return row.next() ? &*batches.emplace(row.text(0), Waiting{row.number(1)}).first : nullptr;
  };
  const auto* at = add(Query(connection,
                             "SELECT batch, rank FROM jobs INDEXED BY jobs_waiting WHERE " MESHGAUGE_CLAIMABLE
                             "AND owner = ? ORDER BY batch, rank LIMIT 1",
                             suspects, owner));
  while (at) {
    at = add(Query(connection,
                   "SELECT batch, rank FROM jobs INDEXED BY jobs_waiting WHERE " MESHGAUGE_CLAIMABLE
                   "AND owner = ? AND batch > ? ORDER BY batch, rank LIMIT 1",
                   suspects, owner, at->first));
  }
  add_running(batches, Query(connection,
                             "SELECT batch, count(*) FROM jobs INDEXED BY jobs_running WHERE state = 1 AND owner = ? "
                             "GROUP BY batch",
                             owner));
  return batches;
}

// What claim_some() takes, in its order: see job_store.h.
std::vector<std::int64_t> next_jobs(Connection& connection, std::size_t most, bool suspects) {
  const AllWaiting owners = waiting_owners(connection, suspects);
  const std::string* const owner = whose_turn(owners);
  if (!owner) return {};
  const AllWaiting batches = waiting_batches(connection, *owner, suspects);
  const std::string& batch = *whose_turn(batches);
  Query row(connection,
            "SELECT number, cost, tries > excused FROM jobs WHERE " MESHGAUGE_CLAIMABLE
            "AND owner = ? AND batch = ? ORDER BY rank, number LIMIT ?",
            suspects, *owner, batch, batch.empty() ? 1 : most);
  std::vector<std::int64_t> numbers;
  std::int64_t cost = 0;
  while (row.next()) {
    cost += row.number(1);
    const bool suspected = row.number(2) != 0;
    if (!numbers.empty() && (suspected || cost > JobStore::kBytesOfOneSecond)) break;
    numbers.push_back(row.number(0));
    if (suspected) break;
  }
  return numbers;
}

Heartbeat hear(Connection& connection, const Beat& beat, TimePoint lease_until) {
  const Token& token = beat.token;
  Query row(
      connection,
      "SELECT cancel_requested, lower, upper, stage, bounds_by FROM jobs WHERE owner = ? AND id = ? AND state = 1 "
      "AND worker = ? AND tries = ?",
      token.key.owner, token.key.id, token.worker, token.tries);
  if (!row.next()) return Heartbeat::lost;
  const bool cancel = row.number(0) != 0;
  const std::optional<Progress> known = progress_of(row, 1, 4);
  const std::optional<Progress> told = beat.progress ? std::optional(narrowed(known, *beat.progress)) : std::nullopt;
  const auto none = [&](auto member) { return told ? std::optional(*told.*member) : std::nullopt; };
  Query(
      connection,
      "UPDATE jobs SET lease_until = ?, lower = ifnull(?, lower), upper = ifnull(?, upper), stage = ifnull(?, stage), "
      "bounds_by = ifnull(?, bounds_by) WHERE owner = ? AND id = ?",
      lease_until, none(&Progress::lower), none(&Progress::upper), none(&Progress::stage), none(&Progress::by),
      token.key.owner, token.key.id)
      .run();
  return cancel ? Heartbeat::cancel : Heartbeat::go_on;
}

// Once more with the same token and time changes nothing, and is no failure: see job_store.h.
bool end_job(Connection& connection, const Token& token, const Ending& ending) {
  assert(has_ended(ending.state));
  return Query(
             connection,
             "UPDATE jobs SET state = ?1, document = ?2, problem = ?3, finished = ?4, expires = ?5, verdict = ?10, "
             "reusable = ?11, work = iif(work = '', '', ifnull(?12, work)), lease_until = NULL WHERE owner = ?6 AND id "
             "= ?7 AND worker = ?8 AND tries = ?9 AND "
             "(state = 1 OR (state = ?1 AND finished = ?4))",
             ending.state, ending.document, ending.problem, ending.finished, ending.expires, token.key.owner,
             token.key.id, token.worker, token.tries, ending.verdict, ending.reusable, ending.work)
             .run() == 1;
}

Claimed claim(Connection& connection, std::int64_t number, const std::string& worker, TimePoint now,
              TimePoint lease_until) {
  Query updated(connection,
                "UPDATE jobs SET state = 1, tries = tries + 1, worker = ?, started = ?, lease_until = ?, stage = NULL "
                "WHERE number = ? RETURNING " MESHGAUGE_JOB_COLUMNS,
                worker, now, lease_until, number);
  updated.next();
  return {token_of(updated), job_of(updated)};
}

}  // namespace

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const std::string& path, std::size_t max_unrecorded,
                                                       const Report& report) {
  Result<Done> made = make_private_file(path);
  if (!made) return made.error();
  Result<std::unique_ptr<Connection>> connection = connect(path);
  if (!connection) return connection.error();
  const Result<Migrated> migrated = migrate(**connection, schema_steps());
  if (!migrated) return migrated.error();
  if (report && migrated->changed() && migrated->from > 0) report(to_string(*migrated));
  return std::unique_ptr<SqliteStore>(new SqliteStore(path, std::move(*connection), max_unrecorded));
}

SqliteStore::SqliteStore(const std::string& path, std::unique_ptr<Connection> connection, std::size_t max_unrecorded)
    : readers_(path),
      writer_(std::move(connection)),
      behind_(max_unrecorded, [this](const WriteBehind::Batch& batch) { return write(batch); }) {}

Result<Inserted> SqliteStore::insert(const NewJob& job) {
  auto inserted = writer_.write([&](Connection& connection) {
    if (insert_row(connection, job)) return Inserted{as_queued(job), false, false};
    std::optional<Job> there = find_job(connection, job.key);
    if (!there) there = find_idempotent_job(connection, job.key.owner, job.idempotency_key);
    const bool conflict = there->fingerprint != job.fingerprint;
    return Inserted{*std::move(there), true, conflict};
  });
  if (inserted && !inserted->existed) signals_.tell(Signal::Kind::work);
  return inserted;
}

Result<std::vector<Claimed>> SqliteStore::claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                                     std::size_t most, Suspects suspects) {
  auto all = writer_.write(
      [&](Connection& connection) {
        std::vector<Claimed> claimed;
        for (const std::int64_t number : next_jobs(connection, most, suspects == Suspects::too)) {
          claimed.push_back(claim(connection, number, worker, now, lease_until));
        }
        return claimed;
      },
      Writer::Promise::fleeting);
  if (!all) return all;
  for (const Claimed& claimed : *all) signals_.tell(Signal::Kind::changed, claimed.token.key);
  return all;
}

Result<std::vector<Heartbeat>> SqliteStore::heartbeats(std::span<const Beat> beats, TimePoint lease_until) {
  auto heard = writer_.write(
      [&](Connection& connection) {
        std::vector<Heartbeat> answers;
        for (const Beat& beat : beats) answers.push_back(hear(connection, beat, lease_until));
        return answers;
      },
      Writer::Promise::fleeting);
  if (!heard) return heard;
  for (const Beat& beat : beats) {
    if (beat.progress) signals_.tell(Signal::Kind::changed, beat.token.key);
  }
  return heard;
}

Result<std::vector<bool>> SqliteStore::finish_all(std::span<const Finished> endings) {
  auto stored = writer_.write([&](Connection& connection) {
    std::vector<bool> ended;
    for (const Finished& finished : endings) ended.push_back(end_job(connection, finished.token, finished.ending));
    return ended;
  });
  if (!stored) return stored;
  for (const Finished& finished : endings) signals_.tell(Signal::Kind::changed, finished.token.key);
  return stored;
}

Result<std::optional<JobState>> SqliteStore::request_cancel(const JobKey& key, Moment moment) {
  if (const auto job = behind_.find(key)) return std::optional(job->state);
  const auto state = writer_.write([&](Connection& connection) -> std::optional<JobState> {
    Query updated(
        connection,
        "UPDATE jobs SET cancel_requested = 1, state = iif(state = 0, 4, 1), finished = iif(state = 0, ?1, NULL), "
        "expires = iif(state = 0, ?2, NULL) WHERE owner = ?3 AND id = ?4 AND state < 2 RETURNING state",
        moment.now, moment.keep_until, key.owner, key.id);
    if (updated.next()) return static_cast<JobState>(updated.number(0));
    Query row(connection, "SELECT state FROM jobs WHERE owner = ? AND id = ?", key.owner, key.id);
    if (!row.next()) return std::nullopt;
    return static_cast<JobState>(row.number(0));
  });
  if (!state || !*state) return state;
  signals_.tell(**state == JobState::running ? Signal::Kind::cancel : Signal::Kind::changed, key);
  return state;
}

Result<Done> SqliteStore::write(const WriteBehind::Batch& batch) {
  return writer_.write([&](Connection& connection) {
    for (const auto& job : batch.jobs) insert_ended_row(connection, *job);
    for (const auto& [mesh, touch] : batch.touches) {
      Query(connection,
            "UPDATE meshes SET last_used = max(last_used, ?), expires = max(expires, ?) WHERE owner = ? AND id = ?",
            touch.last_used, touch.expires, mesh.owner, mesh.id)
          .run();
    }
    return Done{};
  });
}

Result<std::optional<Job>> SqliteStore::get(const JobKey& key) {
  if (const auto job = behind_.find(key)) return std::optional<Job>(*job);
  return readers_.read([&](Connection& connection) { return find_job(connection, key); });
}

Result<std::optional<Job>> SqliteStore::find_idempotent(const std::string& owner, const std::string& idempotency_key) {
  return readers_.read([&](Connection& connection) { return find_idempotent_job(connection, owner, idempotency_key); });
}

Result<bool> SqliteStore::forget(const JobKey& key) {
  if (behind_.find(key)) {
    Result<Done> flushed = flush();
    if (!flushed) return flushed.error();
  }
  return writer_.write([&](Connection& connection) {
    return Query(connection, "DELETE FROM jobs WHERE owner = ? AND id = ? AND state >= 2", key.owner, key.id).run() ==
           1;
  });
}

}  // namespace meshgauge::server::store
