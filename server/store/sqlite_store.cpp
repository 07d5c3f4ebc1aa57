// SqliteStore, except for BatchStore (sqlite_batches.cpp).
#include "server/store/sqlite_store.h"

#include <fcntl.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <utility>

#include "api/base/digest.h"
#include "server/store/data_folder.h"
#include "server/store/rows.h"
#include "server/store/schema.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

// SQLite would make the file readable to every user; its log and index get the mode that it has.
Result<Done> make_private_file(const std::string& path) {
  const Descriptor file = open_file(path, O_RDWR | O_CREAT);
  if (!file) return access_error(errno, "the database '" + path + "' cannot be opened", path);
  return Done{};
}

Result<std::unique_ptr<Connection>> connect(const std::string& path) {
  errno = 0;
  try {
    return std::make_unique<Connection>(path, Connection::Use::write);
  } catch (const SQLite::Exception& exception) {
    return to_error(exception, errno, with_path(path));
  }
}

// What the log holds beyond the database's file must fit into the reserve, or the log could not be emptied on a full
// disk. So it is moved to the file when it is half as large.
void keep_log_small(Connection& connection) {
  constexpr std::uint64_t kPage = 4096, kMostPages = 1000;  // the latter is SQLite's default
  struct statvfs disk {};
  if (::statvfs(connection.path().c_str(), &disk) != 0) return;
  const std::uint64_t pages = reserve_bytes(std::uint64_t{disk.f_blocks} * disk.f_frsize) / 2 / kPage;
  connection.execute(("PRAGMA wal_autocheckpoint = " + std::to_string(std::min(pages, kMostPages))).c_str());
}

constexpr auto kNextClient = R"sql(
    SELECT client, rank FROM jobs INDEXED BY jobs_turns
    WHERE tries >= 0 AND )sql" +
                             kClaimable + R"sql( AND client >= $2
    ORDER BY client, rank LIMIT 1)sql";
constexpr auto kNextBatch = R"sql(
    SELECT batch, rank FROM jobs INDEXED BY jobs_of_client
    WHERE )sql" + kClaimable +
                            R"sql( AND client = $3 AND batch >= $2
    ORDER BY batch, rank LIMIT 1)sql";
constexpr auto kFirstJobs = "SELECT number, cost, tries > excused FROM jobs WHERE " + kClaimable + R"sql(
      AND client = $2 AND batch = $3
    ORDER BY rank, number LIMIT $4)sql";

// The groups that wait: `next` returns name and rank of the first whose name is not less than the one it is given, so
// each costs one step in an index. `running` returns name and number of those of which some run.
std::vector<Group> waiting_groups(const std::function<Query(const std::string& from)>& next, Query&& running) {
  std::vector<Group> groups;
  for (std::string from;; from = groups.back().name + '\0') {
    Query row = next(from);
    if (!row.next()) break;
    groups.push_back({row.text(0), row.number(1), 0});
  }
  while (running.next()) {
    const auto found = std::lower_bound(groups.begin(), groups.end(), running.text(0),
                                        [](const Group& group, const std::string& name) { return group.name < name; });
    if (found != groups.end() && found->name == running.text(0)) found->running = running.number(1);
  }
  return groups;
}

// The rows that claim_some() takes, in its order.
std::vector<std::int64_t> next_jobs(Connection& connection, std::size_t most, bool suspects, JobStore::Clients whose) {
  const auto clients = waiting_groups(
      [&](const std::string& from) { return connection.query(kNextClient, suspects, from); },
      connection.query("SELECT client, count(*) FROM jobs INDEXED BY jobs_running WHERE state = 1 GROUP BY client"));
  const Group* const client = next_group(clients, whose);
  if (!client) return {};
  const auto batches = waiting_groups(
      [&](const std::string& from) { return connection.query(kNextBatch, suspects, from, client->name); },
      connection.query("SELECT batch, count(*) FROM jobs INDEXED BY jobs_running WHERE state = 1 AND client = $1 "
                       "GROUP BY batch",
                       client->name));
  const std::string& batch = next_group(batches)->name;
  Query row = connection.query(kFirstJobs, suspects, client->name, batch, batch.empty() ? 1 : most);
  std::vector<std::int64_t> numbers;
  std::vector<Candidate> candidates;
  while (row.next()) {
    numbers.push_back(row.number(0));
    candidates.push_back({count_in(row, 1), row.number(2) != 0});
  }
  numbers.resize(fit_in_claim(candidates));
  return numbers;
}

constexpr auto kClaimJob = "UPDATE jobs SET " + kClaim + " WHERE number = $1 RETURNING" + kJobColumns;

constexpr auto kHear = "UPDATE jobs SET" + kRenew + R"sql(
    FROM (SELECT $1 AS owner, $2 AS id, $3 AS worker, $4 AS tries, $5 AS lease_until, $6 AS lower, $7 AS upper,
            $8 AS stage, $9 AS bounds_by) AS given
    WHERE )sql" + kHeld +
                       " RETURNING cancel_requested";

Heartbeat hear(Connection& connection, const Beat& beat, TimePoint lease_until) {
  const auto& [token, progress] = beat;
  Query row = connection.query(kHear, token.key.owner, token.key.id, token.worker, token.tries, lease_until,
                               told(progress, &Progress::lower), told(progress, &Progress::upper),
                               told(progress, &Progress::stage), told(progress, &Progress::by));
  if (!row.next()) return Heartbeat::lost;
  return row.number(0) != 0 ? Heartbeat::cancel : Heartbeat::go_on;
}

constexpr auto kEndJob = "UPDATE jobs SET" + kEnd + R"sql(
    FROM (SELECT $1 AS owner, $2 AS id, $3 AS worker, $4 AS tries, $5 AS new_state, $6 AS document, $7 AS problem,
            $8 AS verdict, $9 AS finished, $10 AS expires, $11 AS reusable, $12 AS work) AS given
    WHERE )sql" + kEndable;

bool end_job(Connection& connection, const Token& token, const Ending& ending) {
  assert(has_ended(ending.state));
  return connection
             .query(kEndJob, token.key.owner, token.key.id, token.worker, token.tries, ending.state, ending.document,
                    ending.problem, ending.verdict, ending.finished, ending.expires, ending.reusable, ending.work)
             .run() == 1;
}

constexpr auto kCancelJob =
    "UPDATE jobs SET" + kCancel + " WHERE owner = $1 AND id = $2 AND " + kCancellable + " RETURNING state";

constexpr auto kInsertJob = "INSERT INTO jobs (" + kInsertedColumns + R"sql()
    VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17, $18, $19, $20, $21, $22, $23,
      $24, $25, $26, $27, $28, $29, $30, $31)
    ON CONFLICT DO NOTHING)sql";

// Moves the times of a mesh forward, never back.
void use_mesh(Connection& connection, const BlobKey& key, TimePoint last_used, TimePoint expires) {
  connection
      .query(
          "UPDATE meshes SET last_used = max(last_used, $3), expires = max(expires, $4) WHERE owner = $1 AND id = $2",
          key.owner, key.id, last_used, expires)
      .run();
}

constexpr auto kFindHeld = "SELECT" + kLossColumns + R"sql(
    FROM (SELECT $1 AS owner, $2 AS id, $3 AS worker, $4 AS tries) AS given CROSS JOIN jobs
    WHERE )sql" + kHeld;
constexpr auto kFindLost = "SELECT" + kLossColumns + " FROM jobs WHERE " + kLost;
constexpr auto kHandBackJob = "UPDATE jobs SET" + kHandBack + R"sql(
    FROM (SELECT $4 AS number, $5 AS state, $6 AS excused) AS given
    WHERE jobs.number = given.number)sql";

void hand_back(Connection& connection, const std::vector<LostJob>& lost, const std::string& why, Moment moment) {
  for (const LostJob& job : lost) {
    connection.query(kHandBackJob, why, moment.now, moment.keep_until, job.number, job.after.state, job.after.excused)
        .run();
  }
}

constexpr auto kFindQueued =
    "SELECT" + kJobColumns + " FROM jobs WHERE state = 0 AND batch = '' ORDER BY created, number";
constexpr auto kGiveUpJobs = "UPDATE jobs SET" + kGiveUp + " WHERE " + kNeverRun + " RETURNING owner, id";
constexpr auto kRemoveExpired =
    "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE " + kExpired + " LIMIT $2)";
constexpr auto kRemoveBeyondShare =
    "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE state >= 2 AND owner = $1 ORDER BY" + kGoesFirst +
    " LIMIT $2)";

constexpr Sql kRemoveMeshes(R"sql(
    DELETE FROM meshes
    WHERE (owner, id) IN (SELECT owner, id FROM meshes WHERE expires <= $1 LIMIT $2)
    RETURNING owner, id)sql");

}  // namespace

bool insert_row(Connection& connection, const Job& job, const std::string& work) {
  const std::optional<Progress>& at = job.progress;
  return connection
             .query(kInsertJob, job.key.owner, job.key.id, job.state, job.mesh_a, job.mesh_b, job.hints, job.options,
                    job.cost, rank_of(job), none_if_empty(job.idempotency_key), job.fingerprint, job.trace, job.created,
                    job.expires_if_never_run, job.batch, job.deadline, job.tries, job.cancel_requested, job.started,
                    job.finished, job.expires, told(at, &Progress::lower), told(at, &Progress::upper),
                    told(at, &Progress::stage), job.document, job.problem, job.last_error, job.verdict, work,
                    at ? at->by : std::string(), client_of(job))
             .run() == 1;
}

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const SqliteSettings& settings) {
  Result<Done> made = make_private_file(settings.path);
  if (!made) return made.error();
  Result<std::unique_ptr<Connection>> connection = connect(settings.path);
  if (!connection) return connection.error();
  const Result<Migrated> migrated = migrate(**connection, schema_steps());
  if (!migrated) return migrated.error();
  if (settings.reserve) keep_log_small(**connection);
  if (settings.report && migrated->changed() && migrated->from > 0) settings.report(to_string(*migrated));
  return std::unique_ptr<SqliteStore>(new SqliteStore(settings, std::move(*connection)));
}

SqliteStore::SqliteStore(const SqliteSettings& settings, std::unique_ptr<Connection> connection)
    : files_(settings.path),
      readers_(settings.path, &files_),
      writer_(std::move(connection), settings.reserve, &files_),
      behind_(settings.max_unrecorded, [this](const WriteBehind::Batch& batch) { return write(batch); }) {}

Result<Inserted> SqliteStore::insert(const NewJob& job) {
  auto inserted = writer_.write([&](Connection& connection) {
    Job queued = as_queued(job);
    if (insert_row(connection, queued, "")) return Inserted{std::move(queued), false, false};
    return *existing_job(connection, job);
  });
  if (!inserted) expect_failure();
  if (inserted && !inserted->existed) signals_.tell(Signal::Kind::work);
  return inserted;
}

Result<std::vector<Claimed>> SqliteStore::claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                                     std::size_t most, Suspects suspects, Clients clients) {
  auto all = writer_.write(
      [&](Connection& connection) {
        std::vector<Claimed> claimed;
        for (const std::int64_t number : next_jobs(connection, most, suspects == Suspects::too, clients)) {
          Query row = connection.query(kClaimJob, number, worker, now, lease_until);
          row.next();
          claimed.push_back(claimed_of(row));
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
  const auto state = writer_.write(
      [&](Connection& connection) -> std::optional<JobState> {
        Query updated = connection.query(kCancelJob, key.owner, key.id, moment.now, moment.keep_until);
        if (updated.next()) return static_cast<JobState>(updated.number(0));
        const std::optional<Job> ended = find_job(connection, key);
        return ended ? std::optional(ended->state) : std::nullopt;
      },
      Writer::Promise::removal);
  if (!state || !*state) return state;
  signals_.tell(**state == JobState::running ? Signal::Kind::cancel : Signal::Kind::changed, key);
  return state;
}

Result<Done> SqliteStore::write(const WriteBehind::Batch& batch) {
  return writer_.write([&](Connection& connection) {
    for (const auto& job : batch.jobs) insert_row(connection, *job, "");
    for (const auto& [mesh, touch] : batch.touches) use_mesh(connection, mesh, touch.last_used, touch.expires);
    return Done{};
  });
}

Result<bool> SqliteStore::forget(const JobKey& key) {
  const bool held = behind_.drop(key);
  const Result<bool> removed = writer_.write(
      [&](Connection& connection) {
        return connection.query("DELETE FROM jobs WHERE owner = $1 AND id = $2 AND state >= 2", key.owner, key.id)
                   .run() == 1;
      },
      Writer::Promise::removal);
  return held && removed ? Result<bool>(true) : removed;
}

Result<std::optional<JobState>> SqliteStore::hand_back(const Token& token, const std::string& last_error,
                                                       Moment moment) {
  const auto state = writer_.write([&](Connection& connection) -> std::optional<JobState> {
    const auto lost = lost_jobs(connection.query(kFindHeld, token.key.owner, token.key.id, token.worker, token.tries),
                                false, last_error);
    store::hand_back(connection, lost, last_error, moment);
    return lost.empty() ? std::nullopt : std::optional(lost.front().after.state);
  });
  if (!state || !*state) return state;
  signals_.tell(Signal::Kind::changed, token.key);
  if (**state == JobState::queued) signals_.tell(Signal::Kind::work);
  return state;
}

Result<std::vector<Job>> SqliteStore::recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                              Moment moment) {
  if (const Result<Done> rest = cancel_the_rest(moment); !rest) return rest.error();
  auto queued = writer_.write([&](Connection& connection) {
    const auto lost = lost_jobs(connection.query(kFindLost, dead_workers, moment.now), true, why);
    store::hand_back(connection, lost, why, moment);
    return jobs_of(connection.query(kFindQueued));
  });
  signals_.tell(Signal::Kind::missed);
  signals_.tell(Signal::Kind::work);
  return queued;
}

Result<std::vector<BlobKey>> SqliteStore::used_blobs() { return readers_.read(find_used_blobs<Connection>); }

Result<std::vector<BlobKey>> SqliteStore::known_blobs() { return readers_.read(find_known_blobs<Connection>); }

Result<std::uint64_t> SqliteStore::remove_in_portions(
    const std::function<Result<std::uint64_t>(std::int64_t most)>& remove) {
  std::uint64_t removed = 0;
  std::int64_t most = kPortion;
  while (true) {
    Result<std::uint64_t> portion = remove(most);
    if (!portion && portion.error().code == ErrorCode::storage_full && most > 1) {
      most = std::max<std::int64_t>(1, most / 10);  // what fits into the reserve
      continue;
    }
    if (!portion) return portion;
    removed += *portion;
    if (*portion < static_cast<std::uint64_t>(most)) return removed;
  }
}

// Counts beside the writer: other writes do not wait for it.
Result<std::uint64_t> SqliteStore::remove_beyond_share(std::uint64_t max_kept, std::int64_t most) {
  const auto kept = readers_.read(count_kept<Connection>);
  if (!kept) return kept.error();
  const std::vector<Kept> beyond = beyond_share(*kept, max_kept, static_cast<std::uint64_t>(most));
  if (beyond.empty()) return std::uint64_t{0};
  return writer_.write(
      [&](Connection& connection) {
        std::uint64_t removed = 0;
        for (const auto& [owner, jobs] : beyond) removed += connection.query(kRemoveBeyondShare, owner, jobs).run();
        return removed;
      },
      Writer::Promise::removal);
}

Result<SweptJobs> SqliteStore::sweep_jobs(Moment moment, std::uint64_t max_kept) {
  if (const Result<Done> rest = cancel_the_rest(moment); !rest) return rest.error();
  const auto given_up = writer_.write(
      [&](Connection& connection) {
        return keys_of<JobKey>(connection.query(kGiveUpJobs, moment.now, moment.keep_until));
      },
      Writer::Promise::removal);
  if (!given_up) return given_up.error();
  for (const JobKey& key : *given_up) signals_.tell(Signal::Kind::changed, key);
  Result<std::uint64_t> expired = remove_in_portions([&](std::int64_t most) {
    return writer_.write(
        [&](Connection& connection) { return connection.query(kRemoveExpired, moment.now, most).run(); },
        Writer::Promise::removal);
  });
  if (!expired) return expired.error();
  Result<std::uint64_t> over_cap =
      remove_in_portions([&](std::int64_t most) { return remove_beyond_share(max_kept, most); });
  if (!over_cap) return over_cap.error();
  return SweptJobs{*expired, *over_cap, given_up->size()};
}

Result<Done> SqliteStore::doubt(std::optional<TimePoint> since) {
  return writer_.write([&](Connection& connection) {
    connection.query("UPDATE origin SET doubted = $1", since).run();
    return Done{};
  });
}

// Stores, finds and forgets a job; and then reads as the next start, which opens the files anew.
Result<Done> SqliteStore::try_writing(bool a_job) {
  const TimePoint at = now();
  const Job trial = trial_job(api::random_id(), at);
  const auto found = writer_.write([&](Connection& connection) {
    if (a_job) insert_row(connection, trial, "");
    const bool is_there = !a_job || find_job(connection, trial.key).has_value();
    connection.query("DELETE FROM jobs WHERE owner = $1 AND id = $2", trial.key.owner, trial.key.id).run();
    connection.query("INSERT INTO checks VALUES (1, $1) ON CONFLICT (id) DO UPDATE SET at = excluded.at", at).run();
    return is_there;
  });
  if (!found) return found.error();
  const auto seen = readers_.read_anew([](Connection& connection) {
    Query row = connection.query("SELECT at FROM checks WHERE id = 1");
    return row.next() ? row.time(0) : TimePoint();
  });
  if (!seen) return seen.error();
  if (*found && *seen >= at) return Done{};
  return Error{ErrorCode::storage_damaged, "the database does not have what was just stored in it", "", ""};
}

Result<PutMesh> SqliteStore::put_mesh(const MeshRow& row, const MeshQuota& quota) {
  return writer_.write([&](Connection& connection) {
    if (find_mesh(connection, row.key)) {
      use_mesh(connection, row.key, row.last_used, row.expires);
      return PutMesh{MeshPut::existed, *find_mesh(connection, row.key)};
    }
    const MeshPut what = fits(find_stored(connection, row.key.owner), row.bytes, quota);
    if (what != MeshPut::created) return PutMesh{what, row};
    connection
        .query("INSERT INTO meshes VALUES ($1, $2, $3, $4, $5, $6, $7, $8)", row.key.owner, row.key.id, row.bytes,
               row.media_type, row.file_name, row.created, row.last_used, row.expires)
        .run();
    return PutMesh{MeshPut::created, row};
  });
}

Result<bool> SqliteStore::delete_mesh(const BlobKey& key) {
  return writer_.write(
      [&](Connection& connection) {
        return connection.query("DELETE FROM meshes WHERE owner = $1 AND id = $2", key.owner, key.id).run() == 1;
      },
      Writer::Promise::removal);
}

// A mesh that was just used must stay, also when a full disk does not take the time of its use.
Result<std::vector<BlobKey>> SqliteStore::sweep_meshes(TimePoint now) {
  const Result<Done> flushed = flush();
  if (!flushed && flushed.error().code != ErrorCode::storage_full) return flushed.error();
  const WriteBehind::Touches touches = flushed ? WriteBehind::Touches() : behind_.touches();
  std::vector<BlobKey> removed;
  const auto swept = remove_in_portions([&](std::int64_t most) -> Result<std::uint64_t> {
    const auto portion = writer_.write(
        [&](Connection& connection) {
          for (const auto& [mesh, touch] : touches) {
            if (touch.expires > now) use_mesh(connection, mesh, touch.last_used, touch.expires);
          }
          return keys_of<BlobKey>(connection.query(kRemoveMeshes, now, most));
        },
        Writer::Promise::removal);
    if (!portion) return portion.error();
    removed.insert(removed.end(), portion->begin(), portion->end());
    return portion->size();
  });
  if (!swept) return swept.error();
  return removed;
}

template class CommonStore<SqliteStore>;

}  // namespace meshgauge::server::store
