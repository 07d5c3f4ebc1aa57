// SqliteStore: hand-backs, recovery, counts and sweeps.
#include <algorithm>

#include "server/store/rows.h"
#include "server/store/sqlite_store.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

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

}  // namespace

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

Result<Counts> SqliteStore::counts() {
  Result<Counts> counts = readers_.read(count_jobs<Connection>);
  if (!counts) return counts;
  behind_.add_to(*counts);
  return counts;
}

Result<std::uint64_t> SqliteStore::unended(const std::string& owner, TimePoint now) {
  return readers_.read([&](Connection& connection) { return count_unended(connection, owner, now); });
}

Result<std::vector<BlobKey>> SqliteStore::used_blobs() { return readers_.read(find_used_blobs<Connection>); }

Result<std::vector<BlobKey>> SqliteStore::known_blobs() { return readers_.read(find_known_blobs<Connection>); }

Result<bool> SqliteStore::uses_blob(const BlobKey& key) {
  return readers_.read([&](Connection& connection) { return connection.query(kUsesBlob, key.owner, key.id).next(); });
}

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

Result<Origin> SqliteStore::origin() { return readers_.read(find_origin<Connection>); }

Result<Done> SqliteStore::doubt(std::optional<TimePoint> since) {
  return writer_.write([&](Connection& connection) {
    connection.query("UPDATE origin SET doubted = $1", since).run();
    return Done{};
  });
}

Result<Done> SqliteStore::check() {
  return writer_.write([](Connection& connection) {
    connection.query("INSERT INTO checks VALUES (1, $1) ON CONFLICT (id) DO UPDATE SET at = excluded.at", now()).run();
    return Done{};
  });
}

}  // namespace meshgauge::server::store
