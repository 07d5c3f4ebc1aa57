// What JobStore does with many jobs at once, with one.
#pragma once

#include "server/store/job_store.h"

namespace meshgauge::server::store {

inline Result<Heartbeat> heartbeat(JobStore& jobs, const Token& token, TimePoint lease_until,
                                   const Progress& progress) {
  const Beat beat{token, progress};
  const auto heard = jobs.heartbeats({&beat, 1}, lease_until);
  if (!heard) return heard.error();
  return heard->front();
}

inline Result<bool> finish(JobStore& jobs, const Token& token, const Ending& ending) {
  const Finished finished{token, ending};
  const auto stored = jobs.finish_all({&finished, 1});
  if (!stored) return stored.error();
  return stored->front();
}

}  // namespace meshgauge::server::store
