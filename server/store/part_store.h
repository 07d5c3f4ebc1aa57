// Comparisons that are measured in parts, by several workers: each part is a job with some of the triangles, and the
// whole is a job that can be claimed when all of them have ended, to put their results together. In the same database
// as the jobs, with the same promises and errors (job_store.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

class PartStore {
 public:
  virtual ~PartStore() = default;

  // All of them or none, as JobStore::insert(): what is said there of the job is said here of the whole. The parts are
  // of the same owner, and have neither idempotency keys nor a batch. As long as one of them has not ended, the whole
  // is queued and nobody can claim it; its progress is the interval of all parts, whose upper end is
  // infinite until each of them has one. Who cancels the whole cancels its parts; forgetting and sweeping the whole
  // takes them along, and they are in no count and no list of what their owner has.
  virtual Result<Inserted> insert_parts(const NewJob& whole, std::span<const NewJob> parts) = 0;
  // In the order in which they were inserted; empty: unknown, or not in parts.
  virtual Result<std::vector<Job>> parts(const JobKey& whole) = 0;
  // The greatest lower bound told by those that have ended or run, and in the newest try of each; 0 if none has.
  virtual Result<double> best_lower(const JobKey& whole) = 0;
  // The whole of a job; empty: it is no part.
  virtual Result<std::string> whole_of(const JobKey& part) = 0;
};

}  // namespace meshgauge::server::store
