#include "server/store/postgres/shared_reservations.h"

#include "api/base/digest.h"
#include "server/store/postgres/pool.h"

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::int64_t kLocks = 0x4d475200;  // and 255 more; schema.cpp, control.cpp and batches.cpp have others
constexpr auto kReserveTime = 4s;
constexpr auto kBetweenReconnects = 1s;
constexpr int kTries = 20;  // for a lock that a removal in another process holds; each waits some seconds

constexpr Sql kBucket("($1::int, hashtext(coalesce(current_schema(), '')))");
constexpr auto kShare = "SELECT pg_advisory_lock_shared" + kBucket;
constexpr auto kUnshare = "SELECT pg_advisory_unlock_shared" + kBucket;
constexpr auto kTryLock = "SELECT pg_try_advisory_lock" + kBucket;
constexpr auto kUnlock = "SELECT pg_advisory_unlock" + kBucket;

std::int64_t number_of(std::size_t bucket) { return kLocks + static_cast<std::int64_t>(bucket); }

}  // namespace

std::size_t SharedReservations::bucket_of(const std::string& name) {
  return std::stoul(api::sha256_hex(std::as_bytes(std::span(name))).substr(0, 2), nullptr, 16);
}

PgConnection& SharedReservations::connected() {
  if (connection_) {
    try {
      connection_->notifications();  // notices at once that the connection has ended
    } catch (const PgFailure&) {
    }
  }
  if (!connection_ || !connection_->usable()) {
    connection_.reset();
    shared_.fill(false);
    // While the database is away, reservations must not wait for it each time.
    if (Clock::now() - failed_ < kBetweenReconnects) throw PgFailure{"", "there is no connection", true, false};
    failed_ = Clock::now();
    connection_ = PgConnection::open(database_);
    failed_ = {};
  }
  connection_->set_deadline(Clock::now() + kReserveTime);
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    if (held_[bucket] == 0 || shared_[bucket]) continue;
    connection_->query(kShare, number_of(bucket));
    shared_[bucket] = true;
  }
  return *connection_;
}

Result<bool> SharedReservations::ask(const char* sql, std::size_t bucket) {
  for (bool again = false;; again = true) {
    try {
      PgRows row = connected().query(sql, number_of(bucket));
      return row.next() && row.number(0) != 0;
    } catch (const PgFailure& failure) {
      if (again || !failure.may_pass) return plain_error(failure);
    }
  }
}

// A lock that cannot be taken now is taken by the next connection; until then no reference to the blob can be stored.
void SharedReservations::begin(const std::string& name) {
  Reservations::begin(name);
  const std::size_t bucket = bucket_of(name);
  const std::lock_guard lock(mutex_);
  ++held_[bucket];
  for (int tries = 0; tries < kTries; ++tries) {
    try {
      connected();
      return;
    } catch (const PgFailure& failure) {
      if (!failure.may_pass) return;
    }
  }
}

void SharedReservations::end(const std::string& name) {
  {
    const std::size_t bucket = bucket_of(name);
    const std::lock_guard lock(mutex_);
    if (--held_[bucket] == 0 && shared_[bucket]) {
      shared_[bucket] = false;
      static_cast<void>(ask(kUnshare, bucket));
    }
  }
  Reservations::end(name);
}

// Locks of the same session do not conflict, so this process's own shared lock does not keep it from the exclusive one.
// Reservations::unless_held() tells the names within the process apart.
Result<bool> SharedReservations::unless_held(const std::string& name, const std::function<Result<bool>()>& work) {
  return Reservations::unless_held(name, [&]() -> Result<bool> {
    const std::size_t bucket = bucket_of(name);
    const auto asked = [&](const char* sql) {
      const std::lock_guard lock(mutex_);
      return ask(sql, bucket);
    };
    Result<bool> alone = asked(kTryLock);
    if (!alone || !*alone) return alone;
    Result<bool> done = work();
    static_cast<void>(asked(kUnlock));  // on an error the lock ends with the connection
    return done;
  });
}

}  // namespace meshgauge::server::store
