// Authentication by bearer keys from a file, and the limits of each key: request rate, jobs and storage.
//
// Everything stored belongs to an owner, which is the id of the key that stored it. Without a keys file there is one
// owner, "", with all scopes and no limits but the service's own on storage.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/base/problem.h"
#include "engine/result.h"
#include "server/access/keys.h"
#include "server/http/head.h"

namespace meshgauge::server {

struct Caller {
  std::string owner;
  Scopes scopes;
};

// A problem, and the headers that go with it: WWW-Authenticate, Retry-After.
struct Denial {
  api::Problem problem;
  std::vector<std::pair<std::string, std::string>> headers{};
};

struct AccessClocks {
  std::function<std::chrono::steady_clock::time_point()> steady = std::chrono::steady_clock::now;  // of rates
  std::function<std::chrono::system_clock::time_point()> system = std::chrono::system_clock::now;  // of expiry
};

class Account;  // what one owner uses of its limits

// Counts one queued or running job of an owner until it is destroyed. May outlive the Access.
class JobSlot {
 public:
  JobSlot() = default;  // not counted
  explicit JobSlot(std::shared_ptr<Account> account) : account_(std::move(account)) {}
  JobSlot(JobSlot&& other) noexcept = default;
  JobSlot& operator=(JobSlot&&) = delete;
  ~JobSlot();

 private:
  std::shared_ptr<Account> account_;
};

// Permission to store one job of an owner. Hold it from the count of the owner's jobs in the store until the new job is
// counted there as well.
class JobTurn {
 public:
  JobTurn() = default;                                // for an owner without a limit
  explicit JobTurn(std::shared_ptr<Account> account)  // precondition: the account has counted it
      : account_(std::move(account)) {}
  JobTurn(JobTurn&& other) noexcept : account_(std::move(other.account_)) {}
  JobTurn& operator=(JobTurn&&) = delete;
  ~JobTurn();

 private:
  std::shared_ptr<Account> account_;
};

// Counts bytes of an owner that are being stored. Hold it until they are counted in the store, or discarded.
class StorageHold {
 public:
  StorageHold() = default;
  StorageHold(std::shared_ptr<Account> account, std::uint64_t bytes) : account_(std::move(account)), bytes_(bytes) {}
  StorageHold(StorageHold&& other) noexcept = default;
  StorageHold& operator=(StorageHold&&) = delete;
  ~StorageHold();

 private:
  std::shared_ptr<Account> account_;
  std::uint64_t bytes_ = 0;
};

// Thread safe.
class Access {
 public:
  // `keys_file`: name of the keys file, which only reload() reads; empty: the service runs without keys.
  explicit Access(std::string keys_file, AccessClocks clocks = {});

  // Reads the keys file. Returns the number of keys. After an Error the keys loaded before stay in force. Usage of
  // limits is kept and running jobs go on; a key that was removed is rejected from now on.
  Result<std::size_t> reload();

  bool has_keys() const { return !keys_file_.empty(); }

  // Returns the owner and scopes of the request's key, or a 401. Unknown, expired and disabled keys get the same 401.
  // The time taken depends on the number of keys, not on which one matches.
  std::variant<Caller, Denial> authenticate(const Head& head) const;

  // Returns a 403 if the key lacks the scope; nullopt: it has it.
  static std::optional<Denial> require(const Caller& caller, Scope scope);

  // The limits of the owner; nullopt: it has no key, or not any more.
  std::optional<Allowance> allowance_of(const std::string& owner) const;

  // Takes one request from the owner's rate. Returns a 429 with Retry-After if the rate is exceeded; nullopt: it is
  // not.
  std::optional<Denial> begin_request(const std::string& owner);

  // Counts a job of this process. Returns a 429 if the owner has max_jobs of them already.
  std::variant<JobSlot, Denial> take_job(const std::string& owner);
  JobSlot adopt_job(const std::string& owner);  // counts a job that was accepted before a restart; never denied

  // Enforces max_jobs where several front ends share a store; take_job() knows the jobs of its own process only.
  // `unended` returns the owner's jobs of all processes and may fail; it is called once or twice.
  //
  // Returns a turn, or a 429 if the owner has max_jobs jobs in the store. Far from the limit (8 front ends could each
  // store as many jobs as this one has turns) turns are given at once. Near it they are given one at a time, and the
  // call blocks until the other turns of this owner in this process have ended. So one front end never exceeds the
  // limit, and n of them (up to 8) exceed it by less than n.
  using CountJobs = std::function<Result<std::uint64_t>()>;
  std::variant<JobTurn, Denial> await_turn(const std::string& owner, const CountJobs& unended);
  // Returns the denial that await_turn() would give now, without taking a turn; nullopt: none. Does not wait for turns.
  std::optional<Denial> find_denial(const std::string& owner, const CountJobs& unended) const;

  // Reserves `bytes` of the owner's storage. Returns a 403 if stored() + bytes held + `bytes` exceeds the smaller of
  // `most` and the key's max_storage_bytes. `stored` returns the owner's bytes in the store, including everything
  // stored before a hold was destroyed; it is called under a lock of this owner.
  std::variant<StorageHold, Denial> hold_storage(const std::string& owner, std::uint64_t bytes, std::uint64_t most,
                                                 const std::function<std::uint64_t()>& stored);

 private:
  std::shared_ptr<const std::vector<Key>> keys() const;
  std::shared_ptr<Account> account_of(const std::string& owner) const;  // nullptr: no key has this id (any more)

  const std::string keys_file_;
  const AccessClocks clocks_;
  const std::shared_ptr<Account> nameless_;  // account of the only owner when the service runs without keys
  mutable std::mutex mutex_;
  std::shared_ptr<const std::vector<Key>> keys_;
  std::map<std::string, std::shared_ptr<Account>> accounts_;
};

}  // namespace meshgauge::server
