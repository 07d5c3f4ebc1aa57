// A JobStore that front ends and workers share within one process: a real one that sends signals, has a clock of its
// own, and is away when a test says so.
#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/store/job_store.h"
#include "server/store/signals.h"

namespace meshgauge::server::store {

class HandSignals final : public Signals {
 public:
  std::atomic<bool> lost{false};  // signals are lost

  void listen(Hear hear) override {
    const std::lock_guard lock(mutex_);
    hear_ = std::move(hear);
  }
  void stop_listening() override {
    const std::lock_guard lock(mutex_);
    hear_ = nullptr;
  }
  void send(Signal::Kind kind, const JobKey& job = {}) {
    const std::lock_guard lock(mutex_);
    if (hear_ && !lost) hear_({kind, job});
  }

 private:
  std::mutex mutex_;
  Hear hear_;
};

class SharedStore final : public JobStore {
 public:
  explicit SharedStore(JobStore& behind) : behind_(behind) {}

  std::atomic<bool> gone{false};
  std::atomic<bool> duty{false};
  std::atomic<int> looks{0};  // calls of uses_blob()
  std::atomic<std::chrono::milliseconds> look_takes{std::chrono::milliseconds(0)};
  std::chrono::milliseconds ahead{0};  // of this machine's clock

  // One for each process.
  void tell_to(HandSignals& hearer) {
    const std::lock_guard lock(mutex_);
    hearers_.push_back(&hearer);
  }
  void tell_no_more(HandSignals& hearer) {
    const std::lock_guard lock(mutex_);
    std::erase(hearers_, &hearer);
  }

  Result<Inserted> insert(const NewJob& job) override {
    return there([&] { return behind_.insert(job); });
  }
  Result<std::vector<Claimed>> claim_some(const std::string& worker, TimePoint now, TimePoint lease_until,
                                          std::size_t most, Suspects suspects, Clients clients) override {
    return there([&] { return behind_.claim_some(worker, now, lease_until, most, suspects, clients); });
  }
  Result<std::vector<Heartbeat>> heartbeats(std::span<const Beat> beats, TimePoint lease_until) override {
    return told(beats.front().token.key, [&] { return behind_.heartbeats(beats, lease_until); });
  }
  Result<std::vector<bool>> finish_all(std::span<const Finished> endings) override {
    return told(endings.front().token.key, [&] { return behind_.finish_all(endings); });
  }
  Result<std::optional<JobState>> hand_back(const Token& token, const std::string& last_error, Moment moment) override {
    return there([&] { return behind_.hand_back(token, last_error, moment); });
  }
  Result<std::optional<JobState>> request_cancel(const JobKey& key, Moment moment) override {
    return told(key, [&] { return behind_.request_cancel(key, moment); });
  }
  void record(Job ended) override { behind_.record(std::move(ended)); }
  Result<Done> flush() override {
    return there([&] { return behind_.flush(); });
  }
  Result<std::optional<Job>> get(const JobKey& key) override {
    return there([&] { return behind_.get(key); });
  }
  Result<std::optional<Job>> find_idempotent(const std::string& owner, const std::string& key) override {
    return there([&] { return behind_.find_idempotent(owner, key); });
  }
  Result<bool> forget(const JobKey& key) override {
    return there([&] { return behind_.forget(key); });
  }
  Result<std::vector<Job>> recover(const std::optional<std::string>& dead_workers, const std::string& why,
                                   Moment moment) override {
    return there([&] { return behind_.recover(dead_workers, why, moment); });
  }
  Result<Counts> counts() override {
    return there([&] { return behind_.counts(); });
  }
  Result<std::uint64_t> unended(const std::string& owner, TimePoint now) override {
    return there([&] { return behind_.unended(owner, now); });
  }
  Result<std::vector<BlobKey>> used_blobs() override {
    return there([&] { return behind_.used_blobs(); });
  }
  Result<std::vector<BlobKey>> known_blobs() override {
    return there([&] { return behind_.known_blobs(); });
  }
  Result<bool> uses_blob(const BlobKey& key) override {
    ++looks;
    std::this_thread::sleep_for(look_takes.load());
    return there([&] { return behind_.uses_blob(key); });
  }
  Result<SweptJobs> sweep_jobs(Moment moment, std::uint64_t max_kept) override {
    return there([&] { return behind_.sweep_jobs(moment, max_kept); });
  }
  Result<Origin> origin() override {
    return there([&] { return behind_.origin(); });
  }
  Result<Done> doubt(std::optional<TimePoint> since) override {
    return there([&] { return behind_.doubt(since); });
  }
  Result<Done> check() override {
    return there([&] { return behind_.check(); });
  }
  TimePoint time() const override { return now() + ahead; }
  bool on_duty() override { return duty; }

  void tell(Signal::Kind kind, const JobKey& key = {}) {
    const std::lock_guard lock(mutex_);
    for (HandSignals* hearer : hearers_) hearer->send(kind, key);
  }

 private:
  template <class Call>
  auto there(Call call) -> decltype(call()) {
    if (!gone) return call();
    return Error{ErrorCode::storage_unavailable, "the database is gone, says the test", "", ""};
  }
  template <class Call>
  auto told(const JobKey& key, Call call) -> decltype(call()) {
    auto result = there(call);
    if (result) tell(Signal::Kind::changed, key);
    return result;
  }

  JobStore& behind_;
  std::mutex mutex_;
  std::vector<HandSignals*> hearers_;
};

}  // namespace meshgauge::server::store
