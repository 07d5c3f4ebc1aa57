#include "server/store/batch_store.h"

#include <set>

#include "batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

std::vector<std::string> names(const std::vector<BatchRow>& rows) {
  std::vector<std::string> names;
  for (const BatchRow& row : rows) names.push_back(row.name);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE_TEMPLATE("batches: an inserted batch is read back, also after a restart", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch batch = new_batch("ann", "b", 3);
  batch.items[1].name = "Ünïcode ' \" ; \n";
  batch.items[2].job.deadline = at(700);
  batch.idempotency_key = "k";
  insert(stores.batches(), batch);
  for (int restart = 0; restart < 2; ++restart) {
    for (const Batch& read :
         {batch_in(stores.batches(), batch.key), *got(stores.batches().find_idempotent_batch("ann", "k"))}) {
      CHECK(read.key == batch.key);
      CHECK(read.name == "name of b");
      CHECK(read.created == at(0));
      CHECK_FALSE(read.cancel_requested);
      CHECK_FALSE(read.finished.has_value());
      CHECK_FALSE(read.expires.has_value());
      CHECK(read.counts.total == 3);
      CHECK(read.counts.queued == 3);
      CHECK(read.counts.running == 0);
      CHECK(read.counts.gone == 0);
    }
    const Job job = job_in(stores.jobs(), {"ann", "b/2"});
    CHECK(job.batch == "b");
    CHECK(job.deadline == at(700));
    CHECK(job.hints == batch.items[2].job.hints);
    CHECK(job.idempotency_key.empty());
    CHECK_FALSE(job_in(stores.jobs(), {"ann", "b/1"}).deadline.has_value());
    stores.reopen();
  }
  for (const std::string id : {"b/0", "b/1", "b/2"}) end(stores.jobs(), {"ann", id}, reusable());
  CHECK(names(got(stores.batches().batch_rows(batch.key, BatchStore::Rows::ended, 0, 10))) ==
        Names{"item 0", "Ünïcode ' \" ; \n", "item 2"});
}

TEST_CASE_TEMPLATE("batches: another owner's batches are not visible", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch batch = new_batch("ann", "b", 1);
  batch.idempotency_key = "k";
  insert(stores.batches(), batch);
  end(stores.jobs(), {"ann", "b/0"}, reusable("fail"));
  for (const std::string owner : {"", "bob", "an"}) {
    const JobKey key{owner, "b"};
    CHECK_FALSE(got(stores.batches().get_batch(key)).has_value());
    CHECK_FALSE(got(stores.batches().find_idempotent_batch(owner, "k")).has_value());
    CHECK(got(stores.batches().batch_rows(key, BatchStore::Rows::ended, 0, 10)).empty());
    CHECK(got(stores.batches().batch_rows(key, BatchStore::Rows::failures_first, 0, 10)).empty());
    CHECK_FALSE(got(stores.batches().cancel_batch(key, kNow)));
    CHECK_FALSE(got(stores.batches().forget_batch(key)));
  }
  insert(stores.batches(), new_batch("bob", "b", 2));  // the same id is another batch
  CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.total == 1);
}

TEST_CASE_TEMPLATE("batches: an idempotency key names one batch, and is separate from those of jobs", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  NewJob job = new_job("ann", "1");
  job.idempotency_key = "k";
  insert(stores.jobs(), job);
  NewBatch first = new_batch("ann", "b", 2);
  first.idempotency_key = "k";
  insert(stores.batches(), first);
  NewBatch second = new_batch("ann", "c", 2);
  second.idempotency_key = "k";
  second.fingerprint = first.fingerprint;
  const InsertedBatch same = got(stores.batches().insert_batch(second));
  CHECK(same.existed);
  CHECK_FALSE(same.conflict);
  CHECK(same.batch.key.id == "b");
  CHECK(same.batch.counts.total == 2);
  second.fingerprint = "other";
  CHECK(got(stores.batches().insert_batch(second)).conflict);
  CHECK_FALSE(got(stores.batches().get_batch(second.key)).has_value());
  CHECK_FALSE(got(stores.jobs().get({"ann", "c/0"})).has_value());
  const InsertedBatch again = got(stores.batches().insert_batch(first));  // the same call once more
  CHECK(again.existed);
  CHECK_FALSE(again.conflict);
  CHECK(got(stores.jobs().counts()).queued == 3);
  insert(stores.batches(), new_batch("ann", "d", 1));  // batches without a key do not collide
  insert(stores.batches(), new_batch("ann", "e", 1));
}

TEST_CASE_TEMPLATE("batches: a repetition of a removed batch is not stored", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  BatchStore& batches = stores.batches();
  NewBatch repeated = new_batch("ann", "b", 1);
  repeated.idempotency_key = "k";
  repeated.repeats = true;
  CHECK(got(batches.insert_batch(repeated)).gone);
  insert(batches, new_batch("ann", "b", 1));
  CHECK(got(batches.insert_batch(repeated)).existed);
}

TEST_CASE_TEMPLATE("batches: equal work is one job, among items and batches of one owner", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch first = new_batch("ann", "b", 4);
  first.items[1].work = first.items[0].work;
  first.items[2].work = first.items[3].work = "";  // never deduplicated
  CHECK(insert(stores.batches(), first).counts.total == 4);
  CHECK(got(stores.jobs().counts()).queued == 3);
  end(stores.jobs(), {"ann", "b/0"}, reusable("pass"));
  CHECK(batch_in(stores.batches(), first.key).counts.pass == 2);

  NewBatch second = new_batch("ann", "c", 3);
  second.items[0].work = first.items[0].work;  // done
  second.items[1].work = "";
  second.items[2].work = "";
  NewBatch others = new_batch("bob", "c", 1);
  others.items[0].work = first.items[0].work;
  second.created = at(500);
  const BatchCounts counts = insert(stores.batches(), second).counts;
  CHECK(counts.done == 1);
  CHECK(counts.queued == 2);
  CHECK(insert(stores.batches(), others).counts.queued == 1);  // jobs of another owner are not shared
  const std::vector<BatchRow> rows = got(stores.batches().batch_rows(second.key, BatchStore::Rows::ended, 0, 10));
  REQUIRE(rows.size() == 1);
  REQUIRE(rows[0].job.has_value());
  CHECK(rows[0].job->key.id == "b/0");
  CHECK(rows[0].name == "item 0");
}

TEST_CASE_TEMPLATE("batches: work that was cut short, failed or is to be cancelled is done again", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 6));
  end(jobs, {"ann", "b/0"}, ending());  // not reusable
  end(jobs, {"ann", "b/1"}, ending(JobState::failed));
  got(jobs.request_cancel({"ann", "b/2"}, kNow));
  claimed_token(jobs, {"ann", "b/3"});
  got(jobs.request_cancel({"ann", "b/3"}, kNow));
  claimed_token(jobs, {"ann", "b/4"});  // runs
  end(jobs, {"ann", "b/5"}, reusable());
  NewBatch second = new_batch("ann", "c", 6);
  for (std::size_t i = 0; i < 6; ++i) second.items[i].work = "work of b/" + std::to_string(i);
  const BatchCounts counts = insert(stores.batches(), second).counts;
  CHECK(counts.queued == 4);
  CHECK(counts.running == 1);
  CHECK(counts.done == 1);
}

TEST_CASE_TEMPLATE("batches: a batch whose work was all done before has ended at its start", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.batches(), new_batch("ann", "b", 1));
  end(stores.jobs(), {"ann", "b/0"}, reusable());
  NewBatch second = new_batch("ann", "c", 1);
  second.items[0].work = "work of b/0";
  second.created = at(500);
  CHECK(insert(stores.batches(), second).finished == at(500));
  CHECK(batch_in(stores.batches(), {"ann", "b"}).finished == at(120));
}

TEST_CASE_TEMPLATE("batches: counts, rows that have ended, and failures first", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  const JobKey key{"ann", "b"};
  insert(stores.batches(), new_batch("ann", "b", 9));
  end(jobs, {"ann", "b/8"}, reusable("fail"));
  end(jobs, {"ann", "b/7"}, reusable("pass"));
  end(jobs, {"ann", "b/6"}, reusable("undecided"));
  end(jobs, {"ann", "b/5"}, reusable());
  end(jobs, {"ann", "b/4"}, ending(JobState::failed));
  end(jobs, {"ann", "b/3"}, reusable("fail"));
  got(jobs.request_cancel({"ann", "b/2"}, kNow));
  claimed_token(jobs, {"ann", "b/1"});
  const Batch batch = batch_in(stores.batches(), key);
  CHECK(batch.counts.total == 9);
  CHECK(batch.counts.queued == 1);
  CHECK(batch.counts.running == 1);
  CHECK(batch.counts.done == 5);
  CHECK(batch.counts.failed == 1);
  CHECK(batch.counts.cancelled == 1);
  CHECK(batch.counts.pass == 1);
  CHECK(batch.counts.fail == 2);
  CHECK(batch.counts.undecided == 1);
  CHECK_FALSE(batch.finished.has_value());

  const auto rows = [&](BatchStore::Rows which, std::uint64_t from, std::size_t most) {
    return names(got(stores.batches().batch_rows(key, which, from, most)));
  };
  CHECK(rows(BatchStore::Rows::ended, 0, 3) == Names{"item 2", "item 3", "item 4"});
  CHECK(rows(BatchStore::Rows::ended, 5, 3) == Names{"item 5", "item 6", "item 7"});
  CHECK(rows(BatchStore::Rows::ended, 8, 3) == Names{"item 8"});
  CHECK(rows(BatchStore::Rows::ended, 9, 3).empty());
  CHECK(rows(BatchStore::Rows::failures_first, 0, 10) == Names{"item 3", "item 8", "item 4", "item 6", "item 2"});
  CHECK(rows(BatchStore::Rows::failures_first, 0, 2) == Names{"item 3", "item 8"});
  CHECK(rows(BatchStore::Rows::running, 0, 10) == Names{"item 1"});
  CHECK(rows(BatchStore::Rows::running, 2, 10).empty());
  const BatchRow failed = got(stores.batches().batch_rows(key, BatchStore::Rows::failures_first, 0, 10))[2];
  CHECK(failed.position == 4);
  CHECK(failed.job->state == JobState::failed);
  CHECK(failed.job->document == "{\"d\":1}");

  Ending last = reusable();
  last.finished = at(300);
  last.expires = at(1300);
  end(jobs, {"ann", "b/0"}, last);
  got(jobs.recover("w1", "x", kNow));
  end(jobs, {"ann", "b/1"}, reusable());
  const Batch ended = batch_in(stores.batches(), key);
  CHECK(ended.finished == at(300));
  CHECK(ended.expires == at(1300));
}

TEST_CASE_TEMPLATE("batches: a cancelled batch leaves jobs that other batches want", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 5));
  NewBatch second = new_batch("ann", "c", 2);
  second.items[0].work = "work of b/3";
  insert(stores.batches(), second);
  const Token runs = claimed_token(jobs, {"ann", "b/1"});
  end(jobs, {"ann", "b/2"}, reusable());
  CHECK(got(stores.batches().cancel_batch({"ann", "b"}, kNow)));
  CHECK(got(stores.batches().cancel_batch({"ann", "b"}, kNow)));  // the same call once more
  CHECK(got(heartbeat(jobs, runs, at(170), {})) == Heartbeat::cancel);
  const Job cancelled = job_in(jobs, {"ann", "b/0"});
  CHECK(cancelled.state == JobState::cancelled);
  CHECK(cancelled.finished == kNow.now);
  CHECK(cancelled.expires == kNow.keep_until);
  CHECK(job_in(jobs, {"ann", "b/2"}).state == JobState::done);
  CHECK(job_in(jobs, {"ann", "b/3"}).state == JobState::queued);  // the other batch waits for it
  CHECK(job_in(jobs, {"ann", "c/1"}).state == JobState::queued);
  const Batch batch = batch_in(stores.batches(), {"ann", "b"});
  CHECK(batch.cancel_requested);
  CHECK(batch.counts.cancelled == 2);
  CHECK(batch.counts.running == 1);
  CHECK_FALSE(batch_in(stores.batches(), {"ann", "c"}).cancel_requested);
  CHECK(got(stores.batches().cancel_batch({"ann", "c"}, kNow)));
  CHECK(job_in(jobs, {"ann", "b/3"}).state == JobState::cancelled);  // now no batch does
  CHECK_FALSE(got(stores.batches().cancel_batch({"ann", "unknown"}, kNow)));
}

TEST_CASE_TEMPLATE("batches: forgetting one removes the jobs that no other points at", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 2));
  NewBatch second = new_batch("ann", "c", 1);
  second.items[0].work = "work of b/1";
  insert(stores.batches(), second);
  end(jobs, {"ann", "b/0"}, reusable());
  CHECK_FALSE(got(stores.batches().forget_batch({"ann", "b"})));
  end(jobs, {"ann", "b/1"}, reusable());
  CHECK(got(stores.batches().forget_batch({"ann", "b"})));
  CHECK_FALSE(got(stores.batches().forget_batch({"ann", "b"})));
  CHECK_FALSE(got(stores.batches().get_batch({"ann", "b"})).has_value());
  CHECK_FALSE(got(jobs.get({"ann", "b/0"})).has_value());
  CHECK(got(jobs.get({"ann", "b/1"})).has_value());
  CHECK(batch_in(stores.batches(), {"ann", "c"}).counts.done == 1);
  CHECK(got(stores.batches().forget_batch({"ann", "c"})));
  CHECK_FALSE(got(jobs.get({"ann", "b/1"})).has_value());
}

TEST_CASE_TEMPLATE("batches: a job that is forgotten alone is gone from its batch", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.batches(), new_batch("ann", "b", 2));
  for (const std::string id : {"b/0", "b/1"}) end(stores.jobs(), {"ann", id}, reusable("pass"));
  CHECK(got(stores.jobs().forget({"ann", "b/0"})));
  const Batch batch = batch_in(stores.batches(), {"ann", "b"});
  CHECK(batch.counts.total == 2);
  CHECK(batch.counts.done == 1);
  CHECK(batch.counts.pass == 1);
  CHECK(batch.counts.gone == 1);
  CHECK(batch.finished == at(120));
  const std::vector<BatchRow> rows = got(stores.batches().batch_rows({"ann", "b"}, BatchStore::Rows::ended, 0, 10));
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].name == "item 0");
  CHECK_FALSE(rows[0].job.has_value());
  CHECK(rows[1].job.has_value());
  CHECK(got(stores.batches().batch_rows({"ann", "b"}, BatchStore::Rows::failures_first, 0, 10)).empty());
  CHECK(got(stores.jobs().forget({"ann", "b/1"})));
  CHECK(batch_in(stores.batches(), {"ann", "b"}).finished.has_value());
  CHECK(got(stores.batches().forget_batch({"ann", "b"})));
}

TEST_CASE_TEMPLATE("batches: jobs stay as long as their batch", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 2));
  insert(stores.batches(), new_batch("ann", "c", 1));
  insert(jobs, new_job("ann", "single"));
  for (const std::string id : {"b/0", "b/1", "single"}) end(jobs, {"ann", id}, reusable());
  const Moment late{at(1200), at(2200)};  // all have expired
  CHECK(got(jobs.sweep_jobs(late, 100)).expired == 1);
  CHECK_FALSE(got(jobs.get({"ann", "single"})).has_value());
  CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.done == 2);

  CHECK(got(stores.batches().sweep_batches(at(120))) == 0);  // it ended then, not before
  CHECK(got(stores.batches().sweep_batches(at(121))) == 1);  // the other has not ended
  CHECK_FALSE(got(stores.batches().get_batch({"ann", "b"})).has_value());
  CHECK_FALSE(got(jobs.get({"ann", "b/0"})).has_value());
  CHECK(batch_in(stores.batches(), {"ann", "c"}).counts.queued == 1);
}

TEST_CASE_TEMPLATE("batches: the cap on results holds for jobs of batches", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.batches(), new_batch("ann", "b", 5));
  for (int i = 0; i < 5; ++i) {
    Ending ending = reusable();
    ending.finished = at(120 + i);
    end(stores.jobs(), {"ann", "b/" + std::to_string(i)}, ending);
  }
  CHECK(got(stores.jobs().sweep_jobs({at(200), at(1200)}, 2)).over_cap == 3);
  const BatchCounts counts = batch_in(stores.batches(), {"ann", "b"}).counts;
  CHECK(counts.gone == 3);
  CHECK(counts.done == 2);
}

TEST_CASE_TEMPLATE("batches: a batch whose meshes do not exist is not stored", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  const MeshRow mesh{{"ann", "m"}, 10, "model/stl", "", at(0), at(0), at(1000)};
  NewBatch batch = new_batch("ann", "b", 2);
  batch.idempotency_key = "k";
  batch.meshes = {"m", "n"};
  got(stores.meshes().put_mesh(mesh, {1000}));
  got(stores.meshes().put_mesh({{"bob", "n"}, 10, "model/stl", "", at(0), at(0), at(1000)}, {1000}));
  const InsertedBatch refused = got(stores.batches().insert_batch(batch));
  CHECK(refused.mesh_gone);
  CHECK_FALSE(refused.existed);
  CHECK_FALSE(got(stores.batches().get_batch(batch.key)).has_value());
  CHECK_FALSE(got(stores.jobs().get({"ann", "b/0"})).has_value());
  batch.meshes = {"m"};
  CHECK_FALSE(got(stores.batches().insert_batch(batch)).mesh_gone);
  CHECK(batch_in(stores.batches(), batch.key).counts.queued == 2);
  got(stores.meshes().delete_mesh(mesh.key));
  const InsertedBatch again = got(stores.batches().insert_batch(batch));
  CHECK(again.existed);
  CHECK_FALSE(again.mesh_gone);
}

TEST_CASE_TEMPLATE("batches: ten thousand items", Stores, EVERY_IMPLEMENTATION) {
  constexpr std::size_t kItems = 10'000;
  Stores stores;
  NewBatch batch = new_batch("ann", "b", kItems);
  for (std::size_t i = 0; i < kItems; ++i) batch.items[i].job.mesh_a = "a" + std::to_string(i);
  CHECK(insert(stores.batches(), batch).counts.queued == kItems);
  for (int i = 0; i < 100; ++i) CHECK(got(stores.jobs().uses_blob({"ann", "a" + std::to_string(i)})));
  CHECK_FALSE(got(stores.jobs().uses_blob({"ann", "a10000"})));
  std::set<std::string> claimed;
  for (int i = 0; i < 20; ++i) {
    for (const std::string& id : claim_ids(stores.jobs(), 50)) claimed.insert(id);
  }
  CHECK(claimed.size() == 1000);
  CHECK(batch_in(stores.batches(), batch.key).counts.running == 1000);
  CHECK(got(stores.batches().cancel_batch(batch.key, kNow)));
  CHECK(batch_in(stores.batches(), batch.key).counts.cancelled == 9000);
  std::uint64_t from = 0;
  std::size_t rows = 0;
  while (true) {
    const std::vector<BatchRow> page = got(stores.batches().batch_rows(batch.key, BatchStore::Rows::ended, from, 1000));
    if (page.empty()) break;
    rows += page.size();
    CHECK(page.front().position >= from);
    from = page.back().position + 1;
  }
  CHECK(rows == 9000);
}

TEST_CASE_TEMPLATE("batches: an owner's unended jobs and batches are counted", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  const auto load = [&](const std::string& owner) {
    const BatchStore::Load of = got(stores.batches().batch_load(owner));
    return std::pair(of.jobs, of.batches);
  };
  using Pair = std::pair<std::uint64_t, std::uint64_t>;
  CHECK(load("ann") == Pair{0, 0});
  insert(stores.batches(), new_batch("ann", "b", 3));
  insert(stores.batches(), new_batch("ann", "c", 2));
  insert(stores.batches(), new_batch("bob", "d", 4));
  insert(stores.jobs(), new_job("ann", "alone"));
  claimed_token(stores.jobs(), {"ann", "b/0"});
  CHECK(load("ann") == Pair{5, 2});
  CHECK(load("bob") == Pair{4, 1});
  end(stores.jobs(), {"ann", "c/0"}, reusable());
  end(stores.jobs(), {"ann", "c/1"}, reusable());
  CHECK(load("ann") == Pair{3, 1});
}
