// Who may use the service, and how much of it: bearer keys from a file, with a rate, jobs and storage each.
//
// Everything stored belongs to an owner, the id of the key that stored it. Without a file of keys there is one owner,
// "", who may do everything; of the limits here only the service's own on storage is for it.
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

#include "api/problem.h"
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
  std::vector<std::pair<std::string, std::string>> headers;
};

struct AccessClocks {
  std::function<std::chrono::steady_clock::time_point()> steady = std::chrono::steady_clock::now;  // of rates
  std::function<std::chrono::system_clock::time_point()> system = std::chrono::system_clock::now;  // of expiry
};

class Account;  // what one owner holds

// One job of an owner, queued or running. May outlive the Access.
class JobSlot {
 public:
  JobSlot() = default;  // counts nowhere
  explicit JobSlot(std::shared_ptr<Account> account) : account_(std::move(account)) {}
  JobSlot(JobSlot&& other) noexcept = default;
  JobSlot& operator=(JobSlot&&) = delete;
  ~JobSlot();

 private:
  std::shared_ptr<Account> account_;
};

// Held from the count of an owner's jobs until his new one counts there as well.
class JobTurn {
 public:
  JobTurn() = default;                                // of an owner without a limit
  explicit JobTurn(std::shared_ptr<Account> account)  // taken already
      : account_(std::move(account)) {}
  JobTurn(JobTurn&& other) noexcept : account_(std::move(other.account_)) {}
  JobTurn& operator=(JobTurn&&) = delete;
  ~JobTurn();

 private:
  std::shared_ptr<Account> account_;
};

// Bytes of an owner that are on their way into the store: hold it until they count there, or are gone.
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
  // `keys_file` empty: without keys. reload() reads it.
  explicit Access(std::string keys_file, AccessClocks clocks = {});

  // Reads the file anew. After an Error the keys that were there stay in force. What an owner has used of its limits
  // stays used, jobs that run go on, and an owner without a key any more is let in no more.
  Result<std::size_t> reload();  // how many keys there are

  bool has_keys() const { return !keys_file_.empty(); }

  // Whose key the head carries, in a time that tells nothing about the keys there are. An unknown, an expired and a
  // disabled key get the same 401.
  std::variant<Caller, Denial> authenticate(const Head& head) const;

  static std::optional<Denial> require(const Caller& caller, Scope scope);  // 403

  std::optional<Denial> begin_request(const std::string& owner);  // one of its rate; 429

  std::variant<JobSlot, Denial> take_job(const std::string& owner);  // 429 when it has as many as it may
  JobSlot adopt_job(const std::string& owner);  // counted, and never denied: accepted before a restart

  // For one of several processes that let jobs of the same owners in: take_job() knows its own alone. `unended` says
  // how many there are of all processes, and may fail. 429 when there are as many as may be, though all turns of this
  // process came to be stored. Turns are given at once while they are few beside what the limit leaves, as other
  // processes give theirs meanwhile; closer to it one at a time, and then this may wait. So one process never passes
  // the limit, and several by less than there are of them, for as long as such a job lasts, unless they are many.
  using CountJobs = std::function<Result<std::uint64_t>()>;
  std::variant<JobTurn, Denial> await_turn(const std::string& owner, const CountJobs& unended);
  // Whether it would be denied now.
  std::optional<Denial> find_denial(const std::string& owner, const CountJobs& unended) const;

  // 403 when `bytes` more than `stored()` and what is held already is more than the owner may store: `most`, as any
  // owner, and no more than its key says. `stored` must see what was stored before a hold was given back; it is asked
  // under a lock of this owner.
  std::variant<StorageHold, Denial> hold_storage(const std::string& owner, std::uint64_t bytes, std::uint64_t most,
                                                 const std::function<std::uint64_t()>& stored);

 private:
  std::shared_ptr<const std::vector<Key>> keys() const;
  std::shared_ptr<Account> account_of(const std::string& owner) const;  // nullptr: not limited, or gone

  const std::string keys_file_;
  const AccessClocks clocks_;
  const std::shared_ptr<Account> nameless_;  // of the only owner when there are no keys
  mutable std::mutex mutex_;
  std::shared_ptr<const std::vector<Key>> keys_;
  std::map<std::string, std::shared_ptr<Account>> accounts_;
};

}  // namespace meshgauge::server
