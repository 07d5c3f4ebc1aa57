// The jobs that this process knows by their ids. Thread safe.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "server/jobs/live_job.h"

namespace meshgauge::server {

class LiveJobs {
 public:
  void add(const std::shared_ptr<LiveJob>& job) {
    const std::lock_guard lock(mutex_);
    jobs_[job->key.id] = job;
  }

  void remove(const LiveJob& job) {
    const std::lock_guard lock(mutex_);
    jobs_.erase(job.key.id);
  }

  std::shared_ptr<LiveJob> find(const store::JobKey& key) const {  // null: there is none
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(key.id);
    return found != jobs_.end() && found->second->key == key ? found->second : nullptr;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<LiveJob>> jobs_;
};

}  // namespace meshgauge::server
