// Steps that tests of batches share.
#pragma once

#include "job_steps.h"

namespace meshgauge::server::store {

// A batch whose item n has the job "ID/n", each with work of its own.
inline NewBatch new_batch(const std::string& owner, const std::string& id, std::size_t items) {
  NewBatch batch;
  batch.key = {owner, id};
  batch.name = "name of " + id;
  batch.fingerprint = "print of " + id;
  batch.created = at(0);
  for (std::size_t i = 0; i < items; ++i) {
    const std::string number = std::to_string(i);
    BatchItem item{"item " + number, new_job(owner, id + "/" + number), "work of " + id + "/" + number};
    item.job.batch = id;
    batch.items.push_back(std::move(item));
  }
  return batch;
}

inline Batch insert(BatchStore& batches, const NewBatch& batch) {
  InsertedBatch inserted = got(batches.insert_batch(batch));
  REQUIRE_FALSE(inserted.existed);
  return inserted.batch;
}

inline Batch batch_in(BatchStore& batches, const JobKey& key) {
  const std::optional<Batch> batch = got(batches.get_batch(key));
  REQUIRE(batch.has_value());
  return *batch;
}

inline Ending reusable(const std::string& verdict = "") {
  Ending ending{JobState::done, "{\"d\":1}", "", at(120), at(1120)};
  ending.verdict = verdict;
  ending.reusable = true;
  return ending;
}

inline void end(JobStore& jobs, const JobKey& key, const Ending& ending) {
  REQUIRE(got(finish(jobs, claimed_token(jobs, key), ending)));
}

// The ids of the jobs of one claim.
inline std::vector<std::string> claim_ids(JobStore& jobs, std::size_t most,
                                          JobStore::Suspects suspects = JobStore::Suspects::too) {
  std::vector<std::string> ids;
  for (const Claimed& claimed : got(jobs.claim_some("w1", at(50), at(110), most, suspects))) {
    ids.push_back(claimed.token.key.id);
  }
  return ids;
}

}  // namespace meshgauge::server::store
