#include "server/access/access.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <limits>

#include "server/base/token_bucket.h"

namespace meshgauge::server {

using api::ProblemKind;

namespace {

TokenBucket bucket_of(const Allowance& allowance, TokenBucket::Time now) {
  return {static_cast<double>(allowance.requests_per_minute) / 60, static_cast<double>(allowance.burst), now};
}

}  // namespace

class Account {
 public:
  Account(const Allowance& allowance, TokenBucket::Time now)
      : allowance_(allowance), bucket_(bucket_of(allowance, now)) {}

  void change(const Allowance& allowance, TokenBucket::Time now) {
    const std::lock_guard lock(mutex_);
    allowance_ = allowance;
    bucket_.change(static_cast<double>(allowance.requests_per_minute) / 60, static_cast<double>(allowance.burst), now);
  }

  // Returns the time until the rate allows a request; nullopt: one was taken.
  std::optional<std::chrono::duration<double>> begin_request(TokenBucket::Time now) {
    const std::lock_guard lock(mutex_);
    if (bucket_.take(now)) return std::nullopt;
    return bucket_.wait();
  }

  // Returns the limit if it is reached; nullopt: the job is counted.
  std::optional<std::uint64_t> take_job() {
    const std::lock_guard lock(mutex_);
    if (jobs_ >= allowance_.max_jobs) return allowance_.max_jobs;
    ++jobs_;
    return std::nullopt;
  }

  Allowance allowance() {
    const std::lock_guard lock(mutex_);
    return allowance_;
  }

  // Returns the number of turns before this one.
  std::uint64_t take_turn() {
    const std::lock_guard gate(gate_);
    const std::lock_guard lock(mutex_);
    return turns_++;
  }

  // Waits until all turns have ended. While the lock is held no other thread gets a turn.
  std::unique_lock<std::mutex> end_turns() {
    std::unique_lock gate(gate_);
    std::unique_lock lock(mutex_);
    no_turns_.wait(lock, [this] { return turns_ == 0; });
    return gate;
  }
  void take_turn(const std::unique_lock<std::mutex>& /*of end_turns()*/) {
    const std::lock_guard lock(mutex_);
    ++turns_;
  }

  void give_turn() {
    const std::lock_guard lock(mutex_);
    if (--turns_ == 0) no_turns_.notify_all();
  }

  void adopt_job() {
    const std::lock_guard lock(mutex_);
    ++jobs_;
  }

  void give_job() {
    const std::lock_guard lock(mutex_);
    --jobs_;
  }

  // Returns the limit if it would be exceeded; nullopt: the bytes are held.
  std::optional<std::uint64_t> hold(std::uint64_t bytes, std::uint64_t most,
                                    const std::function<std::uint64_t()>& stored) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t limit = std::min(most, allowance_.max_storage_bytes);
    const std::uint64_t left = limit - std::min(stored(), limit);
    if (held_ > left || bytes > left - held_) return limit;
    held_ += bytes;
    return std::nullopt;
  }

  void release(std::uint64_t bytes) {
    const std::lock_guard lock(mutex_);
    held_ -= bytes;
  }

 private:
  std::mutex mutex_;
  Allowance allowance_;
  TokenBucket bucket_;
  std::uint64_t jobs_ = 0;
  std::uint64_t held_ = 0;
  std::uint64_t turns_ = 0;
  std::condition_variable no_turns_;
  std::mutex gate_;  // of turns; locked before mutex_
};

namespace {

constexpr std::uint64_t kProcesses = 8;  // front ends that may store jobs of one owner at the same time

// RFC 6750 section 3: no error code when the request carries no key.
Denial unauthorized(const char* detail, bool presented) {
  return {{ProblemKind::unauthorized, detail},
          {{"WWW-Authenticate",
            std::string(R"(Bearer realm="meshgauge")") + (presented ? R"(, error="invalid_token")" : "")}}};
}

Denial too_many(std::string detail, std::chrono::duration<double> wait) {
  const auto seconds = std::max(1L, static_cast<long>(std::ceil(wait.count())));
  return {{ProblemKind::too_many_requests, std::move(detail)}, {{"Retry-After", std::to_string(seconds)}}};
}

Denial too_many_jobs(std::uint64_t limit) {
  return too_many("the key has " + std::to_string(limit) +
                      " comparisons queued or running, its limit max_jobs; wait for one to end",
                  std::chrono::seconds(1));
}

std::optional<Denial> denial_of(Account& account, const Result<std::uint64_t>& unended) {
  if (!unended) return Denial{api::to_problem(unended.error())};
  const std::uint64_t limit = account.allowance().max_jobs;
  return *unended >= limit ? std::optional(too_many_jobs(limit)) : std::nullopt;
}

Denial over_quota(std::uint64_t limit, std::uint64_t most) {
  const std::string bytes = std::to_string(limit) + " bytes";
  return {{ProblemKind::quota_exceeded,
           (limit < most ? "the key's meshes would exceed its limit max_storage_bytes of "
                         : "stored meshes and those of waiting comparisons would exceed the limit of ") +
               bytes + "; delete some"}};
}

// For the owner of a service without keys, which only the service's own settings limit.
Allowance unlimited() {
  Allowance all;
  all.max_storage_bytes = std::numeric_limits<std::uint64_t>::max();
  return all;
}

// The key was removed from the file after the request was authenticated.
Denial key_removed() { return unauthorized("the key was removed from the service", true); }

}  // namespace

JobSlot::~JobSlot() {
  if (account_) account_->give_job();
}

JobTurn::~JobTurn() {
  if (account_) account_->give_turn();
}

StorageHold::~StorageHold() {
  if (account_) account_->release(bytes_);
}

Access::Access(std::string keys_file, AccessClocks clocks)
    : keys_file_(std::move(keys_file)),
      clocks_(std::move(clocks)),
      nameless_(std::make_shared<Account>(unlimited(), clocks_.steady())),
      keys_(std::make_shared<std::vector<Key>>()) {}

Result<std::size_t> Access::reload() {
  if (!has_keys()) return std::size_t{0};
  auto loaded = load_keys(keys_file_);
  if (!loaded) return loaded.error();
  const auto now = clocks_.steady();
  const std::lock_guard lock(mutex_);
  std::map<std::string, std::shared_ptr<Account>> accounts;
  for (const Key& key : *loaded) {
    const auto known = accounts_.find(key.id);
    if (known != accounts_.end()) known->second->change(key.allowance, now);
    accounts[key.id] = known != accounts_.end() ? known->second : std::make_shared<Account>(key.allowance, now);
  }
  accounts_ = std::move(accounts);
  keys_ = std::make_shared<const std::vector<Key>>(std::move(*loaded));
  return keys_->size();
}

std::shared_ptr<const std::vector<Key>> Access::keys() const {
  const std::lock_guard lock(mutex_);
  return keys_;
}

std::shared_ptr<Account> Access::account_of(const std::string& owner) const {
  const std::lock_guard lock(mutex_);
  const auto found = accounts_.find(owner);
  return found == accounts_.end() ? nullptr : found->second;
}

std::variant<Caller, Denial> Access::authenticate(const Head& head) const {
  if (!has_keys()) return Caller{"", {true, true}};
  const std::string_view token = bearer_token(head);
  if (token.empty()) return unauthorized("send a key: Authorization: Bearer <token>", false);
  const std::string digest = token_sha256(token.substr(0, kMaxTokenBytes + 1));
  const auto all = keys();
  const Key* match = nullptr;
  for (const Key& key : *all) {  // without an early exit, so that the time does not depend on the match
    for (const std::string& known : key.sha256) {
      if (same_digest(known, digest)) match = &key;
    }
  }
  const bool counts = match && !match->disabled && (!match->expires || clocks_.system() < *match->expires);
  if (!counts) return unauthorized("the key is unknown, disabled or expired", true);
  return Caller{match->id, match->scopes};
}

std::optional<Denial> Access::require(const Caller& caller, Scope scope) {
  if (scope == Scope::compare ? caller.scopes.compare : caller.scopes.metrics) return std::nullopt;
  const std::string name = scope == Scope::compare ? "compare" : "metrics";
  return Denial{
      {ProblemKind::forbidden, "this request needs a key with the scope '" + name + "'"},
      {{"WWW-Authenticate", R"(Bearer realm="meshgauge", error="insufficient_scope", scope=")" + name + "\""}}};
}

std::optional<Allowance> Access::allowance_of(const std::string& owner) const {
  const auto account = account_of(owner);
  return account ? std::optional(account->allowance()) : std::nullopt;
}

std::optional<Denial> Access::begin_request(const std::string& owner) {
  if (!has_keys()) return std::nullopt;
  const auto account = account_of(owner);
  if (!account) return key_removed();
  const auto wait = account->begin_request(clocks_.steady());
  if (!wait) return std::nullopt;
  return too_many("the key has exceeded its rate, requests_per_minute; retry later", *wait);
}

std::variant<JobSlot, Denial> Access::take_job(const std::string& owner) {
  if (!has_keys()) return JobSlot{};
  auto account = account_of(owner);
  if (!account) return key_removed();
  if (const auto limit = account->take_job()) return too_many_jobs(*limit);
  return JobSlot(std::move(account));
}

std::variant<JobTurn, Denial> Access::await_turn(const std::string& owner, const CountJobs& unended) {
  if (!has_keys()) return JobTurn{};
  auto account = account_of(owner);
  if (!account) return key_removed();
  {
    const std::uint64_t before = account->take_turn();
    JobTurn turn(account);
    const auto there = unended();
    if (auto denial = denial_of(*account, there)) return std::move(*denial);
    if (*there + kProcesses * before < account->allowance().max_jobs) return turn;
  }
  // Jobs of earlier turns may have been counted twice above, and those of other processes not at all.
  const auto gate = account->end_turns();
  if (auto denial = denial_of(*account, unended())) return std::move(*denial);
  account->take_turn(gate);
  return JobTurn(std::move(account));
}

std::optional<Denial> Access::find_denial(const std::string& owner, const CountJobs& unended) const {
  if (!has_keys()) return std::nullopt;
  const auto account = account_of(owner);
  return account ? denial_of(*account, unended()) : key_removed();
}

JobSlot Access::adopt_job(const std::string& owner) {
  auto account = account_of(owner);
  if (account) account->adopt_job();
  return JobSlot(std::move(account));
}

std::variant<StorageHold, Denial> Access::hold_storage(const std::string& owner, std::uint64_t bytes,
                                                       std::uint64_t most,
                                                       const std::function<std::uint64_t()>& stored) {
  auto account = has_keys() ? account_of(owner) : nameless_;
  if (!account) return key_removed();
  if (const auto limit = account->hold(bytes, most, stored)) return over_quota(*limit, most);
  return StorageHold(std::move(account), bytes);
}

}  // namespace meshgauge::server
