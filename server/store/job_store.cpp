#include "server/store/job_store.h"

#include <utility>

namespace meshgauge::server::store {

Result<Heartbeat> JobStore::heartbeat(const Token& token, TimePoint lease_until, const Progress& progress) {
  const Beat beat{token, progress};
  const auto heard = heartbeats({&beat, 1}, lease_until);
  if (!heard) return heard.error();
  return heard->front();
}

Result<bool> JobStore::finish(const Token& token, const Ending& ending) {
  const Finished finished{token, ending};
  const auto stored = finish_all({&finished, 1});
  if (!stored) return stored.error();
  return stored->front();
}

Result<std::vector<Job>> JobStore::get_many(std::span<const JobKey> keys) {
  std::vector<Job> jobs;
  for (const JobKey& key : keys) {
    auto job = get(key);
    if (!job) return job.error();
    if (*job) jobs.push_back(std::move(**job));
  }
  return jobs;
}

}  // namespace meshgauge::server::store
