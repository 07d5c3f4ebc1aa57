// A JobStore in front of another one, which fails like a disk when a test says so.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

class FlakyStore final : public JobStore {
 public:
  explicit FlakyStore(JobStore& behind) : behind_(behind) {}

  // Like a full disk: writes fail, reads do not.
  std::atomic<bool> full{false};
  std::atomic<int> refused{0};
  std::atomic<int> unfinished{0};                // of those, results that could not be stored
  std::atomic<int> finishes{0};                  // calls of finish_all()
  std::string refused_document;                  // a result with it cannot be stored; empty: none
  void set_damaged(std::set<std::string> ids) {  // of jobs whose rows cannot be written
    const std::lock_guard lock(mutex_);
    damaged_ = std::move(ids);
  }
  // Called after each stored claim_some(), before its answer. false: the answer is lost. Empty: not called.
  std::function<bool(const std::vector<Claimed>&)> answers_claim;

  Result<Inserted> insert(const NewJob& job) override {
    return written([&] { return behind_.insert(job); });
  }
  Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                          std::size_t most, Suspects suspects, Clients clients) override {
    auto claimed = written([&] { return behind_.claim_some(worker, now, lease_until, most, suspects, clients); });
    if (!claimed || !answers_claim || answers_claim(*claimed)) return claimed;
    return Error{ErrorCode::storage_unavailable, "the answer is lost, says the test", "", ""};
  }
  Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) override {
    return written([&] { return behind_.heartbeats(beats, lease_until); });
  }
  Result<std::vector<bool>> finish_all(std::span<const Finished> endings) override {
    ++finishes;
    unfinished += full.load();
    for (const Finished& finished : endings) {
      if (is_damaged(finished.token)) return damage();
      if (refused_document.empty() || finished.ending.document != refused_document) continue;
      return Error{ErrorCode::internal, "a document that cannot be kept, says the test", "", ""};
    }
    return written([&] { return behind_.finish_all(endings); });
  }
  Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error, Moment moment) override {
    if (is_damaged(token)) return damage();
    return written([&] { return behind_.hand_back(token, last_error, moment); });
  }
  Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) override {
    return written([&] { return behind_.request_cancel(key, moment); });
  }
  void record(Job ended) override { behind_.record(std::move(ended)); }
  Result<Done> flush() override {
    return written([&] { return behind_.flush(); });
  }
  Result<std::optional<Job>> get(const JobKey& key) override { return behind_.get(key); }
  Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& key) override {
    return behind_.find_idempotent(owner, key);
  }
  Result<bool> forget(const JobKey& key) override {
    return written([&] { return behind_.forget(key); });
  }
  Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                   Moment moment) override {
    return written([&] { return behind_.recover(dead_workers, why, moment); });
  }
  Result<Counts> counts() override { return behind_.counts(); }
  Result<std::uint64_t> unended(const std::string& owner, TimePoint now) override {
    return behind_.unended(owner, now);
  }
  Result<std::vector<BlobKey>> used_blobs() override { return behind_.used_blobs(); }
  Result<std::vector<BlobKey>> known_blobs() override { return behind_.known_blobs(); }
  Result<bool> uses_blob(const BlobKey& key) override { return behind_.uses_blob(key); }
  Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) override {
    return written([&] { return behind_.sweep_jobs(moment, max_kept); });
  }
  Result<Origin> origin() override { return behind_.origin(); }
  Result<Done> doubt(std::optional<TimePoint> since) override {
    return written([&] { return behind_.doubt(since); });
  }
  Result<Done> check() override {
    return written([&] { return behind_.check(); });
  }

 private:
  bool is_damaged(const Token& token) const {
    const std::lock_guard lock(mutex_);
    return damaged_.contains(token.key.id);
  }
  Error damage() {
    ++refused;
    return {ErrorCode::internal, "a damaged row, says the test", "", ""};
  }

  template <class Write>
  auto written(Write write) -> decltype(write()) {
    if (!full) return write();
    ++refused;
    return Error{ErrorCode::storage_full, "a full disk, says the test", "", ""};
  }

  JobStore& behind_;
  mutable std::mutex mutex_;
  std::set<std::string> damaged_;
};

}  // namespace meshgauge::server::store
