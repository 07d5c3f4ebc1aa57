// Deduplication of the work of batches.
#include "batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

TEST_CASE_TEMPLATE("batches: results are found by the work that was done, not by the requested one", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  NewBatch asked = new_batch("ann", "b", 2);
  asked.items[0].work = "of the new version";
  asked.items[1].work = "";  // never deduplicated
  insert(stores.batches(), asked);
  Ending by_another = reusable();
  by_another.work = "of the old version";
  for (const std::string id : {"b/0", "b/1"}) {
    const Finished ended{claimed_token(jobs, {"ann", id}), by_another};
    CHECK(got(jobs.finish_all({&ended, 1})) == std::vector{true});
    CHECK(got(jobs.finish_all({&ended, 1})) == std::vector{true});  // once more changes nothing
  }

  NewBatch again = new_batch("ann", "c", 3);
  again.items[0].work = "of the new version";
  again.items[1].work = "of the old version";
  again.items[2].work = "of the old version";
  const BatchCounts counts = insert(stores.batches(), again).counts;
  CHECK(counts.queued == 1);
  CHECK(counts.done == 2);
  const std::vector<BatchRow> rows = got(stores.batches().batch_rows(again.key, BatchStore::Rows::ended, 0, 10));
  REQUIRE(rows.size() == 2);
  for (const BatchRow& row : rows) CHECK(row.job->key.id == "b/0");

  end(jobs, {"ann", "c/0"}, reusable());  // by a worker of the requested version
  NewBatch third = new_batch("ann", "d", 1);
  third.items[0].work = "of the new version";
  CHECK(insert(stores.batches(), third).counts.done == 1);
}
