// The statements of Listings, for either database (rows.h).
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "server/store/listings.h"
#include "server/store/rows.h"

namespace meshgauge::server::store {

// The rows of a page: each table has an index of these three columns, so a page costs its own rows.
inline constexpr Sql kOfPage(R"sql(
    WHERE owner = $1 AND (created, id) < ($2, $3)
    ORDER BY created DESC, id DESC LIMIT $4)sql");

inline constexpr auto kListedMeshes = "SELECT " + kMeshColumns + " FROM meshes" + kOfPage;
inline constexpr auto kListedJobs = R"sql(
    SELECT owner, id, state, created, started, finished, expires, mesh_a, mesh_b, hints, verdict, batch
    FROM jobs)sql" + kOfPage;
inline constexpr auto kListedBatches = "SELECT owner, id, name, created, cancel_requested FROM batches" + kOfPage;

// The row of query(sql, owner, created, id, most).
template <class Db>
auto query_page(Db& db, const char* sql, const Page& page) {
  const Page::Place none{TimePoint(TimePoint::duration(std::numeric_limits<std::int64_t>::max())), ""};
  const Page::Place& after = page.after ? *page.after : none;
  return db.query(sql, page.owner, after.created, after.id, page.most);
}

template <class Db>
std::vector<MeshRow> list_meshes(Db& db, const Page& page) {
  auto row = query_page(db, kListedMeshes, page);
  std::vector<MeshRow> meshes;
  while (auto mesh = first_mesh(row)) meshes.push_back(*std::move(mesh));
  return meshes;
}

template <class Db>
std::vector<ListedJob> list_jobs(Db& db, const Page& page) {
  auto row = query_page(db, kListedJobs, page);
  std::vector<ListedJob> jobs;
  while (row.next()) {
    jobs.push_back({{row.text(0), row.text(1)},
                    static_cast<JobState>(row.number(2)),
                    row.time(3),
                    row.time_if_any(4),
                    row.time_if_any(5),
                    row.time_if_any(6),
                    row.text(7),
                    row.text(8),
                    row.text(9),
                    row.text(10),
                    row.text(11)});
  }
  return jobs;
}

template <class Db>
std::vector<ListedBatch> list_batches(Db& db, const Page& page) {
  std::map<std::string, std::uint64_t> unended;
  auto mine =
      db.query("SELECT batch, count(*) FROM jobs WHERE state IN (0, 1) AND owner = $1 AND batch <> '' GROUP BY batch",
               page.owner);
  while (mine.next()) unended.emplace(mine.text(0), count_in(mine, 1));
  std::vector<ListedBatch> batches;
  auto row = query_page(db, kListedBatches, page);
  while (row.next()) {
    const auto found = unended.find(row.text(1));
    batches.push_back({{row.text(0), row.text(1)},
                       row.text(2),
                       row.time(3),
                       row.number(4) != 0,
                       found == unended.end() ? 0 : found->second});
  }
  return batches;
}

template <class Db>
JobsOfOwner count_jobs_of(Db& db, const std::string& owner) {
  JobsOfOwner jobs;
  auto row =
      db.query("SELECT state, count(*) FROM jobs WHERE state IN (0, 1, 2, 3, 4) AND owner = $1 GROUP BY state", owner);
  while (row.next()) jobs.by_state.at(count_in(row, 0)) = count_in(row, 1);
  jobs.bytes = only_count(
      db.query("SELECT CAST(coalesce(sum(cost), 0) AS bigint) FROM jobs WHERE state IN (0, 1) AND owner = $1", owner));
  return jobs;
}

template <class Db>
std::uint64_t count_batches_of(Db& db, const std::string& owner) {
  return only_count(db.query("SELECT count(*) FROM batches WHERE owner = $1", owner));
}

}  // namespace meshgauge::server::store
