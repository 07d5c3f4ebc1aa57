// SqliteStore: what looks at many jobs at once.
#include <algorithm>

#include "server/store/job_rows.h"
#include "server/store/policy.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kPortion = 500;  // rows that one transaction removes: other writes wait for it

// A running job that is to be handed back.
struct Lost {
  JobKey key;
  Loss loss;
};

constexpr const char* kOfToken =
    "SELECT owner, id, tries, excused, cancel_requested, batch != '', stage IS NOT NULL FROM jobs WHERE owner = ? AND "
    "id = ? AND state = 1 AND worker = ? AND tries = ?";
constexpr const char* kOfTheDead =
    "SELECT owner, id, tries, excused, cancel_requested, batch != '', stage IS NOT NULL FROM jobs WHERE state = 1 AND "
    "iif(?2 IS NULL, lease_until <= ?1, substr(worker, 1, length(?2)) = ?2)";

std::vector<Lost> lost_jobs(Query&& row) {
  std::vector<Lost> all;
  while (row.next()) {
    all.push_back({{row.text(0), row.text(1)},
                   {static_cast<unsigned>(row.number(2)), static_cast<unsigned>(row.number(3)), row.number(4) != 0,
                    row.number(5) != 0, row.number(6) != 0}});
  }
  return all;
}

// With an empty `why` its last error stays.
void hand_back(Connection& connection, const JobKey& key, const AfterLoss& after, const std::string& why,
               Moment moment) {
  const bool ended = has_ended(after.state);
  Query(connection,
        "UPDATE jobs SET state = ?, excused = ?, worker = '', lease_until = NULL, finished = ?, expires = ?, "
        "last_error = iif(? = '', last_error, ?) WHERE owner = ? AND id = ?",
        after.state, after.excused, ended ? std::optional(moment.now) : std::nullopt,
        ended ? std::optional(moment.keep_until) : std::nullopt, why, why, key.owner, key.id)
      .run();
}

std::vector<Job> queued_jobs(Connection& connection) {
  Query row(connection,
            "SELECT " MESHGAUGE_JOB_COLUMNS " FROM jobs WHERE state = 0 AND batch = '' ORDER BY created, number");
  std::vector<Job> jobs;
  while (row.next()) jobs.push_back(job_of(row));
  return jobs;
}

void add(Counts& counts, JobState state, std::uint64_t number) {
  switch (state) {
    case JobState::queued:
      counts.queued = number;
      return;
    case JobState::running:
      counts.running = number;
      return;
    case JobState::done:
      counts.done = number;
      return;
    case JobState::failed:
      counts.failed = number;
      return;
    case JobState::cancelled:
      counts.cancelled = number;
      return;
  }
}

void add_waiting(Connection& connection, Counts& counts) {
  Query unawaited(connection, "SELECT count(*) FROM jobs WHERE state IN (0, 1) AND batch = '' AND deadline IS NULL");
  if (unawaited.next()) counts.unawaited = static_cast<std::uint64_t>(unawaited.number(0));
  Query oldest(connection, "SELECT created FROM jobs WHERE state = 0 ORDER BY created LIMIT 1");
  if (oldest.next()) counts.oldest_queued = oldest.time(0);
}

std::vector<JobKey> give_up_waiting(Connection& connection, Moment moment) {
  Query row(connection,
            "UPDATE jobs SET state = 3, finished = ?1, expires = ?2, last_error = iif(last_error = '', "
            "'nobody ran it in time', last_error) WHERE state = 0 AND expires_if_never_run <= ?1 RETURNING owner, id",
            moment.now, moment.keep_until);
  return keys_of(row);
}

// What batches point at stays with them.
std::uint64_t remove_expired(Connection& connection, TimePoint now, std::int64_t most) {
  return Query(connection,
               "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE state >= 2 AND expires <= ? AND NOT "
               "EXISTS (SELECT 1 FROM batch_items AS items WHERE items.owner = jobs.owner AND items.job = jobs.id) "
               "LIMIT ?)",
               now, most)
      .run();
}

std::vector<Kept> kept_jobs(Connection& connection) {
  Query row(connection, "SELECT owner, count(*) FROM jobs WHERE state >= 2 GROUP BY owner");
  std::vector<Kept> kept;
  while (row.next()) kept.push_back({row.text(0), static_cast<std::uint64_t>(row.number(1))});
  return kept;
}

// Those that were given to record() come first: their clients have had their answers.
std::uint64_t remove_oldest(Connection& connection, const std::string& owner, std::uint64_t wanted) {
  const std::uint64_t records =
      Query(connection,
            "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE state >= 2 AND owner = ? AND worker = '' "
            "AND tries = 1 ORDER BY finished, number LIMIT ?)",
            owner, wanted)
          .run();
  if (records == wanted) return records;
  return records + Query(connection,
                         "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE state >= 2 AND owner = ? "
                         "ORDER BY finished, number LIMIT ?)",
                         owner, wanted - records)
                       .run();
}

std::uint64_t remove_over_share(Connection& connection, std::uint64_t max_kept, std::int64_t most) {
  return remove_over_share(
      kept_jobs(connection), max_kept, static_cast<std::uint64_t>(most),
      [&](const std::string& owner, std::uint64_t wanted) { return remove_oldest(connection, owner, wanted); });
}

}  // namespace

Result<std::optional<JobState>> SqliteStore::hand_back(const Token& token, const std::string& last_error,
                                                       Moment moment) {
  const auto state = writer_.write([&](Connection& connection) -> std::optional<JobState> {
    const auto lost = lost_jobs(Query(connection, kOfToken, token.key.owner, token.key.id, token.worker, token.tries));
    if (lost.empty()) return std::nullopt;
    const AfterLoss after = after_hand_back(lost.front().loss, last_error.empty());
    store::hand_back(connection, token.key, after, last_error, moment);
    return after.state;
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
    for (const auto& [key, loss] : lost_jobs(Query(connection, kOfTheDead, moment.now, dead_workers))) {
      const AfterLoss after = why.empty() ? after_hand_back(loss, true) : after_loss(loss);
      store::hand_back(connection, key, after, after.excused > loss.excused ? "" : why, moment);
    }
    return queued_jobs(connection);
  });
  signals_.tell(Signal::Kind::missed);
  signals_.tell(Signal::Kind::work);
  return queued;
}

Result<Counts> SqliteStore::counts() {
  Result<Counts> counts = readers_.read([](Connection& connection) {
    Counts counted;
    Query row(connection, "SELECT state, count(*) FROM jobs GROUP BY state");
    while (row.next()) add(counted, static_cast<JobState>(row.number(0)), static_cast<std::uint64_t>(row.number(1)));
    add_waiting(connection, counted);
    return counted;
  });
  if (!counts) return counts;
  behind_.add_to(*counts);
  return counts;
}

Result<std::uint64_t> SqliteStore::unended(const std::string& owner, TimePoint now) {
  return readers_.read([&](Connection& connection) {
    Query row(
        connection,
        "SELECT count(*) FROM jobs WHERE state IN (0, 1) AND owner = ? AND batch = '' AND NOT cancel_requested AND "
        "(deadline IS NULL OR deadline > ?)",
        owner, now);
    return row.next() ? static_cast<std::uint64_t>(row.number(0)) : std::uint64_t{0};
  });
}

Result<std::vector<BlobKey>> SqliteStore::used_blobs() {
  return readers_.read([](Connection& connection) {
    Query row(
        connection,
        "SELECT owner, mesh_a FROM jobs WHERE state IN (0, 1) UNION SELECT owner, mesh_b FROM jobs WHERE state IN "
        "(0, 1) UNION SELECT owner, id FROM meshes");
    std::vector<BlobKey> keys;
    while (row.next()) keys.push_back({row.text(0), row.text(1)});
    return keys;
  });
}

Result<bool> SqliteStore::uses_blob(const BlobKey& key) {
  return readers_.read([&](Connection& connection) {
    Query mesh(connection, "SELECT 1 FROM meshes WHERE owner = ? AND id = ?", key.owner, key.id);
    if (mesh.next()) return true;
    Query job(connection,
              "SELECT 1 FROM jobs WHERE state IN (0, 1) AND owner = ?1 AND mesh_a = ?2 UNION ALL "
              "SELECT 1 FROM jobs WHERE state IN (0, 1) AND owner = ?1 AND mesh_b = ?2 LIMIT 1",
              key.owner, key.id);
    return job.next();
  });
}

Result<std::uint64_t> SqliteStore::remove_in_portions(
    const std::function<std::uint64_t(Connection&, std::int64_t most)>& remove) {
  std::uint64_t removed = 0;
  while (true) {
    Result<std::uint64_t> portion = writer_.write([&](Connection& connection) { return remove(connection, kPortion); });
    if (!portion) return portion;
    removed += *portion;
    if (*portion < kPortion) return removed;
  }
}

Result<SweptJobs> SqliteStore::sweep_jobs(Moment moment, std::uint64_t max_kept) {
  if (const Result<Done> rest = cancel_the_rest(moment); !rest) return rest.error();
  const auto given_up = writer_.write([&](Connection& connection) { return give_up_waiting(connection, moment); });
  if (!given_up) return given_up.error();
  for (const JobKey& key : *given_up) signals_.tell(Signal::Kind::changed, key);
  Result<std::uint64_t> expired = remove_in_portions(
      [&](Connection& connection, std::int64_t most) { return remove_expired(connection, moment.now, most); });
  if (!expired) return expired.error();
  Result<std::uint64_t> over_cap = remove_in_portions(
      [&](Connection& connection, std::int64_t most) { return remove_over_share(connection, max_kept, most); });
  if (!over_cap) return over_cap.error();
  return SweptJobs{*expired, *over_cap, given_up->size()};
}

Result<Done> SqliteStore::check() {
  return writer_.write([](Connection& connection) {
    Query(connection, "INSERT INTO checks VALUES (1, ?) ON CONFLICT (id) DO UPDATE SET at = excluded.at", now()).run();
    return Done{};
  });
}

}  // namespace meshgauge::server::store
