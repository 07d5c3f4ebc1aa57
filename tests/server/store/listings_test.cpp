#include "server/store/listings.h"

#include "batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

using Ids = std::vector<std::string>;

template <class Row>
Ids ids_of(const std::vector<Row>& rows) {
  Ids ids;
  for (const Row& row : rows) ids.push_back(row.key.id);
  return ids;
}

template <class Row>
Page after(const Row& row, std::size_t most) {
  return {row.key.owner, Page::Place{row.created, row.key.id}, most};
}

void put(MeshIndex& meshes, const std::string& owner, const std::string& id, TimePoint created) {
  got(meshes.put_mesh({{owner, id}, 10, "", "", created, created, at(1000)}, {1000}));
}

}  // namespace

TEST_CASE_TEMPLATE("listings: meshes of one owner, newest first, page by page", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  for (const auto& [id, second] : {std::pair("c", 1), std::pair("a", 2), std::pair("b", 2), std::pair("d", 3)}) {
    put(stores.meshes(), "ann", id, at(second));
  }
  put(stores.meshes(), "bob", "x", at(2));
  Listings& listings = stores.listings();
  CHECK(ids_of(got(listings.list_meshes({"ann", std::nullopt, 10}))) == Ids{"d", "b", "a", "c"});
  CHECK(ids_of(got(listings.list_meshes({"bob", std::nullopt, 10}))) == Ids{"x"});
  CHECK(got(listings.list_meshes({"eve", std::nullopt, 10})).empty());

  const auto first = got(listings.list_meshes({"ann", std::nullopt, 2}));
  CHECK(ids_of(first) == Ids{"d", "b"});
  CHECK(first.front() == got(stores.meshes().get_mesh({"ann", "d"})));
  // What comes meanwhile is not in the pages that follow, and a page begins where its last row was.
  put(stores.meshes(), "ann", "e", at(4));
  CHECK(got(stores.meshes().delete_mesh({"ann", "b"})));
  CHECK(ids_of(got(listings.list_meshes(after(first.back(), 1)))) == Ids{"a"});
  CHECK(ids_of(got(listings.list_meshes(after(first.back(), 10)))) == Ids{"a", "c"});
}

TEST_CASE_TEMPLATE("listings: comparisons with their states, and the bytes of those that wait", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  Listings& listings = stores.listings();
  for (int second = 0; second < 4; ++second) {
    NewJob job = new_job("ann", std::to_string(second));
    job.created = at(second);
    insert(stores.jobs(), job);
  }
  insert(stores.jobs(), new_job("bob", "x"));
  end(stores.jobs(), {"ann", "1"}, reusable("fail"));
  got(stores.jobs().request_cancel({"ann", "2"}, kNow));
  claimed_token(stores.jobs(), {"ann", "3"});
  stores.jobs().record(ended_job("ann", "recorded"));
  got(stores.jobs().flush());

  const auto rows = got(listings.list_jobs({"ann", std::nullopt, 3}));
  CHECK(ids_of(rows) == Ids{"3", "2", "1"});
  CHECK(rows[0].state == JobState::running);
  CHECK(rows[1].state == JobState::cancelled);
  const ListedJob& ended = rows[2];
  CHECK(ended.state == JobState::done);
  CHECK(ended.verdict == "fail");
  CHECK(ended.created == at(1));
  CHECK(ended.started == at(50));
  CHECK(ended.finished == at(120));
  CHECK(ended.expires == at(1120));
  CHECK(ended.mesh_a == std::string(64, 'a'));
  CHECK(ended.mesh_b == std::string(64, 'b'));
  CHECK(ended.hints == new_job("", "").hints);
  CHECK(ids_of(got(listings.list_jobs(after(ended, 3)))) == Ids{"recorded", "0"});

  const JobsOfOwner jobs = got(listings.jobs_owned("ann"));
  CHECK(jobs.by_state == std::array<std::uint64_t, 5>{1, 1, 2, 0, 1});
  CHECK(jobs.bytes == 2000);
  CHECK(got(listings.jobs_owned("eve")).by_state == std::array<std::uint64_t, 5>{});
}

TEST_CASE_TEMPLATE("listings: batches, and how many of their comparisons have not ended", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  Listings& listings = stores.listings();
  insert(stores.batches(), new_batch("ann", "old", 2));
  NewBatch later = new_batch("ann", "new", 3);
  later.created = at(5);
  insert(stores.batches(), later);
  insert(stores.batches(), new_batch("bob", "x", 1));
  end(stores.jobs(), {"ann", "new/1"}, reusable());
  got(stores.batches().cancel_batch({"ann", "old"}, kNow));

  const auto rows = got(listings.list_batches({"ann", std::nullopt, 10}));
  CHECK(ids_of(rows) == Ids{"new", "old"});
  CHECK(rows[0].name == "name of new");
  CHECK(rows[0].created == at(5));
  CHECK_FALSE(rows[0].cancel_requested);
  CHECK(rows[0].unended == 2);
  CHECK(rows[1].cancel_requested);
  CHECK(rows[1].unended == 0);
  CHECK(ids_of(got(listings.list_batches(after(rows[0], 10)))) == Ids{"old"});
  CHECK(got(listings.batches_owned("ann")) == 2);
  const auto comparisons = got(listings.list_jobs({"bob", std::nullopt, 10}));
  CHECK(comparisons.front().batch == "x");
}
