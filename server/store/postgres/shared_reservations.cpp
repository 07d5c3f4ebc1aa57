#include "server/store/postgres/shared_reservations.h"

#include "api/digest.h"

namespace meshgauge::server::store {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::int64_t kLocks = 0x4d475200;  // and 255 more: beside those of schema.cpp, control.cpp and batches.cpp
constexpr auto kStatementTime = 4s;
constexpr auto kBetweenConnects = 1s;

#define MESHGAUGE_PG_BUCKET "($1::int, hashtext(coalesce(current_schema(), '')))"

}  // namespace

std::size_t SharedReservations::bucket_of(const std::string& name) {
  return std::stoul(api::sha256_hex(std::as_bytes(std::span(name))).substr(0, 2), nullptr, 16);
}

PgConnection& SharedReservations::connected() {
  if (!connection_ || !connection_->usable()) {
    connection_.reset();
    shared_.fill(false);
    // Whoever reserves while the database is gone must not wait for it each time.
    if (Clock::now() - failed_ < kBetweenConnects) throw PgFailure{"", "the database is gone", true, true};
    failed_ = Clock::now();
    connection_ = PgConnection::open(database_);
    failed_ = {};
  }
  connection_->set_deadline(Clock::now() + kStatementTime);
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    if (held_[bucket] == 0 || shared_[bucket]) continue;
    connection_->query("SELECT pg_advisory_lock_shared" MESHGAUGE_PG_BUCKET,
                       kLocks + static_cast<std::int64_t>(bucket));
    shared_[bucket] = true;
  }
  return *connection_;
}

void SharedReservations::begin(const std::string& name) {
  Reservations::begin(name);
  const std::lock_guard lock(mutex_);
  if (held_[bucket_of(name)]++ > 0) return;
  try {
    connected();
  } catch (const PgFailure&) {  // taken with the next connection; until then nobody can store what refers to it
  }
}

void SharedReservations::end(const std::string& name) {
  {
    const std::size_t bucket = bucket_of(name);
    const std::lock_guard lock(mutex_);
    if (--held_[bucket] == 0 && shared_[bucket]) {
      shared_[bucket] = false;
      try {
        if (connection_ && connection_->usable()) {
          connection_->set_deadline(Clock::now() + kStatementTime);
          connection_->query("SELECT pg_advisory_unlock_shared" MESHGAUGE_PG_BUCKET,
                             kLocks + static_cast<std::int64_t>(bucket));
        }
      } catch (const PgFailure&) {  // the lock is gone with the connection
        connection_.reset();
      }
    }
  }
  Reservations::end(name);
}

// One boolean.
Result<bool> SharedReservations::locked(const char* sql, std::size_t bucket) {
  const std::lock_guard lock(mutex_);
  try {
    PgRows row = connected().query(sql, kLocks + static_cast<std::int64_t>(bucket));
    return row.next() && row.number(0) != 0;
  } catch (const PgFailure& failure) {
    return to_error(failure);
  }
}

// What this process holds itself is no obstacle to its own exclusive lock: names of the same bucket are told apart
// within it.
Result<bool> SharedReservations::unless_held(const std::string& name, const std::function<Result<bool>()>& work) {
  return Reservations::unless_held(name, [&]() -> Result<bool> {
    const std::size_t bucket = bucket_of(name);
    const Result<bool> alone = locked("SELECT pg_try_advisory_lock" MESHGAUGE_PG_BUCKET, bucket);
    if (!alone || !*alone) return alone;
    Result<bool> done = work();
    static_cast<void>(locked("SELECT pg_advisory_unlock" MESHGAUGE_PG_BUCKET, bucket));  // else the connection is gone
    return done;
  });
}

}  // namespace meshgauge::server::store
