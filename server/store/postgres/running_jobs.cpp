// PostgresStore: claims, heartbeats and ends of jobs.
#include <cassert>

#include "api/base/digest.h"
#include "server/store/postgres/postgres_store.h"
#include "server/store/rows.h"
#include "server/store/transitions.h"

namespace meshgauge::server::store {
namespace {

// A column for RETURNING: the commit of the statement waits for no disk, so a crash may undo it.
constexpr Sql kFleeting("set_config('synchronous_commit', 'off', true)");

// Claims the jobs of claim_some(), in its order (job_store.h). $5 most, $6 kBytesOfOneSecond, $7 number of this claim,
// $8 whether clients with a running job are passed over.
//   clients, groups  each client that waits, and of a client each batch ('' is none), found by one step in an index
//   from
//                    each to the next: a claim costs as much as there are clients, and groups of the one it takes from
//   turns, ordered   next_group()
//   taken            the first group with a job that no other process is claiming, and its first jobs, locked
//   members          fit_in_claim()
// `tries >= 0` selects the index jobs_turns. The last step finds its rows by their numbers alone: they are locked as
// queued, and a second condition on the state would let PostgreSQL, whose estimates do not know a new batch yet, read
// all queued jobs instead.
constexpr auto kClaimSome = R"sql(
    WITH RECURSIVE
      clients (client, rank) AS (
        (SELECT client, rank FROM jobs WHERE tries >= 0 AND )sql" +
                            kClaimable + R"sql( ORDER BY client, rank LIMIT 1)
        UNION ALL
        SELECT next.client, next.rank FROM clients CROSS JOIN LATERAL (
          SELECT client, rank FROM jobs
          WHERE tries >= 0 AND )sql" +
                            kClaimable + R"sql( AND client > clients.client
          ORDER BY client, rank LIMIT 1) AS next),
      turns AS (
        SELECT client FROM (
          SELECT client, sum(running) AS running, min(rank) AS rank FROM (
            SELECT client, 0 AS running, rank FROM clients
            UNION ALL SELECT client, 1, NULL FROM jobs WHERE state = 1) AS each
          GROUP BY client) AS load
        WHERE rank IS NOT NULL AND NOT ($8 AND running > 0) ORDER BY running, rank),
      taken AS MATERIALIZED (
        SELECT locked.* FROM turns CROSS JOIN LATERAL (
          WITH RECURSIVE groups (batch, rank) AS (
            (SELECT batch, rank FROM jobs WHERE )sql" +
                            kClaimable + R"sql( AND client = turns.client ORDER BY batch, rank LIMIT 1)
            UNION ALL
            SELECT next.batch, next.rank FROM groups CROSS JOIN LATERAL (
              SELECT batch, rank FROM jobs
              WHERE )sql" + kClaimable +
                            R"sql( AND client = turns.client AND batch > groups.batch
              ORDER BY batch, rank LIMIT 1) AS next)
          SELECT batch FROM (
            SELECT batch, sum(running) AS running, min(rank) AS rank FROM (
              SELECT batch, 0 AS running, rank FROM groups
              UNION ALL SELECT batch, 1, NULL FROM jobs WHERE state = 1 AND client = turns.client) AS each
            GROUP BY batch) AS load
          WHERE rank IS NOT NULL ORDER BY running, rank) AS ordered
        CROSS JOIN LATERAL (
          SELECT array_agg(number ORDER BY rank, number) AS numbers, array_agg(cost ORDER BY rank, number) AS costs,
            array_agg(tries > excused ORDER BY rank, number) AS suspects
          FROM (
            SELECT number, rank, cost, tries, excused FROM jobs
            WHERE )sql" + kClaimable +
                            R"sql( AND client = turns.client AND batch = ordered.batch
            ORDER BY rank, number LIMIT CASE WHEN ordered.batch = '' THEN 1 ELSE $5 END
            FOR NO KEY UPDATE SKIP LOCKED) AS mine
          HAVING count(*) > 0) AS locked
        LIMIT 1),
      members AS (
        SELECT member.number, member.place, sum(member.cost) OVER upto AS cost,
          bool_or(member.suspect) OVER upto AS suspect
        FROM taken CROSS JOIN LATERAL unnest(numbers, costs, suspects)
          WITH ORDINALITY AS member (number, cost, suspect, place)
        WINDOW upto AS (ORDER BY member.place)),
      claimed AS (
        UPDATE jobs SET )sql" +
                            kClaim + R"sql(, claim = $7
        WHERE number = ANY (ARRAY(SELECT number FROM members WHERE place = 1 OR (cost <= $6 AND NOT suspect)))
        RETURNING jobs.*)
    SELECT)sql" + kJobColumns +
                            ", " + kFleeting + " FROM claimed ORDER BY rank, number";

constexpr auto kClaimedBefore =
    "SELECT" + kJobColumns + " FROM jobs WHERE state = 1 AND claim = $1 ORDER BY rank, number";

std::int64_t random_number() {
  const std::string digits = api::random_id().substr(0, 15);
  return std::stoll(digits, nullptr, 16);
}

std::vector<Claimed> all_claimed(PgRows row) {
  std::vector<Claimed> all;
  while (row.next()) all.push_back(claimed_of(row));
  return all;
}

constexpr auto kHearBeats = R"sql(
    WITH locked AS MATERIALIZED (
      SELECT found.number, given.*, $9::int8 AS lease_until
      FROM (SELECT * FROM unnest($1::bytea[], $2::bytea[], $3::bytea[], $4::int8[], $5::float8[], $6::float8[],
                $7::bytea[], $8::bytea[])
              WITH ORDINALITY AS beat (owner, id, worker, tries, lower, upper, stage, bounds_by, place)
            ORDER BY owner, id) AS given
      CROSS JOIN LATERAL (SELECT number FROM jobs WHERE )sql" +
                            kHeld + R"sql( FOR UPDATE) AS found)
    UPDATE jobs SET)sql" + kRenew +
                            R"sql(
    FROM locked AS given WHERE jobs.number = given.number
    RETURNING place, cancel_requested, batch, )sql" +
                            kFleeting;

struct Heard {
  std::vector<Heartbeat> answers;
  std::vector<JobKey> to_tell;  // jobs of no batch
};

Heard hear(PgConnection& connection, std::span<const Beat> beats, TimePoint lease_until) {
  std::vector<std::string> owners, ids, workers;
  std::vector<std::int64_t> tries;
  std::vector<std::optional<double>> lowers, uppers;
  std::vector<std::optional<std::string>> stages, engines;
  for (const auto& [token, progress] : beats) {
    owners.push_back(token.key.owner);
    ids.push_back(token.key.id);
    workers.push_back(token.worker);
    tries.push_back(token.tries);
    lowers.push_back(told(progress, &Progress::lower));
    uppers.push_back(told(progress, &Progress::upper));
    stages.push_back(told(progress, &Progress::stage));
    engines.push_back(told(progress, &Progress::by));
  }
  PgRows row = connection.query(kHearBeats, owners, ids, workers, tries, lowers, uppers, stages, engines, lease_until);
  Heard heard{std::vector<Heartbeat>(beats.size(), Heartbeat::lost), {}};
  while (row.next()) {
    const auto place = static_cast<std::size_t>(row.number(0) - 1);
    heard.answers[place] = row.number(1) != 0 ? Heartbeat::cancel : Heartbeat::go_on;
    if (beats[place].progress && row.bytes(2).empty()) heard.to_tell.push_back(beats[place].token.key);
  }
  return heard;
}

constexpr auto kEndJobs = R"sql(
    WITH locked AS MATERIALIZED (
      SELECT found.number, given.*
      FROM (SELECT * FROM unnest($1::bytea[], $2::bytea[], $3::bytea[], $4::int8[], $5::int8[], $6::bytea[],
                $7::bytea[], $8::bytea[], $9::int8[], $10::int8[], $11::int8[], $12::bytea[])
              WITH ORDINALITY AS ending (owner, id, worker, tries, new_state, document, problem, verdict, finished,
                expires, reusable, work, place)
            ORDER BY owner, id, place) AS given
      CROSS JOIN LATERAL (SELECT number FROM jobs WHERE )sql" +
                          kEndable + R"sql( FOR NO KEY UPDATE) AS found)
    UPDATE jobs SET)sql" + kEnd +
                          R"sql(
    FROM locked AS given WHERE jobs.number = given.number
    RETURNING place, jobs.owner, jobs.id, jobs.batch)sql";

struct Ended {
  std::vector<bool> stored;
  std::vector<JobKey> to_tell;  // jobs of no batch
};

Ended end_jobs(PgConnection& connection, std::span<const Finished> endings) {
  std::vector<std::string> owners, ids, workers, documents, problems, verdicts;
  std::vector<std::int64_t> tries, states, finished, expires, reusable;
  std::vector<std::optional<std::string>> works;
  for (const auto& [token, ending] : endings) {
    assert(has_ended(ending.state));
    owners.push_back(token.key.owner);
    ids.push_back(token.key.id);
    workers.push_back(token.worker);
    tries.push_back(token.tries);
    states.push_back(static_cast<std::int64_t>(ending.state));
    documents.push_back(ending.document);
    problems.push_back(ending.problem);
    verdicts.push_back(ending.verdict);
    finished.push_back(ending.finished.time_since_epoch().count());
    expires.push_back(ending.expires.time_since_epoch().count());
    reusable.push_back(ending.reusable ? 1 : 0);
    works.push_back(ending.work);
  }
  PgRows row = connection.query(kEndJobs, owners, ids, workers, tries, states, documents, problems, verdicts, finished,
                                expires, reusable, works);
  Ended ended{std::vector<bool>(endings.size(), false), {}};
  while (row.next()) {
    ended.stored[static_cast<std::size_t>(row.number(0) - 1)] = true;
    if (row.bytes(3).empty()) ended.to_tell.push_back({row.text(1), row.text(2)});
  }
  return ended;
}

}  // namespace

Result<std::vector<Claimed>> PostgresStore::claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                                       std::size_t most, Suspects suspects, Clients clients) {
  const std::int64_t claim = random_number();
  bool repeated = false;
  Result<std::vector<Claimed>> claimed = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    if (std::exchange(repeated, true)) {
      if (auto before = all_claimed(connection.query(kClaimedBefore, claim)); !before.empty()) return before;
    }
    return all_claimed(connection.query(kClaimSome, suspects == Suspects::too, worker, now, lease_until, most,
                                        kBytesOfOneSecond, claim, clients == Clients::with_none_running));
  });
  if (!claimed) return claimed;
  for (const Claimed& one : *claimed) {
    if (one.job.deadline) control_.tell(Signal::Kind::changed, one.token.key);
  }
  return claimed;
}

Result<std::vector<Heartbeat>> PostgresStore::heartbeats(std::span<const Beat> beats, TimePoint lease_until) {
  if (beats.empty()) return std::vector<Heartbeat>();
  Result<Heard> heard =
      pool_.run(Promise::fleeting, [&](PgConnection& connection) { return hear(connection, beats, lease_until); });
  if (!heard) return heard.error();
  for (const JobKey& key : heard->to_tell) control_.tell(Signal::Kind::changed, key);
  return std::move(heard->answers);
}

Result<std::vector<bool>> PostgresStore::finish_all(std::span<const Finished> endings) {
  if (endings.empty()) return std::vector<bool>();
  Result<Ended> ended =
      pool_.run(Promise::durable, [&](PgConnection& connection) { return end_jobs(connection, endings); });
  if (!ended) return ended.error();
  for (const JobKey& key : ended->to_tell) control_.tell(Signal::Kind::changed, key);
  return std::move(ended->stored);
}

}  // namespace meshgauge::server::store
