// Reservations of blobs that all processes of one database know of (blob_store.h), by advisory locks: each name is in
// one of 256 buckets, and a process shares the lock of a bucket while it holds a reservation in it. So ten thousand
// reservations at once cost at most 256 round trips; and a blob may look reserved, and stay for remove_unused(),
// because another one of its bucket is.
//
// The locks are those of one connection, and end with it: while the database is gone nothing is reserved, but neither
// is anything removed or referred to. A new connection takes them again.
#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <string>

#include "server/store/blob_store.h"
#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

class SharedReservations final : public Reservations {
 public:
  explicit SharedReservations(std::string database) : database_(std::move(database)) {}

  Result<bool> unless_held(const std::string& name, const std::function<Result<bool>()>& work) override;

 protected:
  void begin(const std::string& name) override;
  void end(const std::string& name) override;

 private:
  static constexpr std::size_t kBuckets = 256;

  static std::size_t bucket_of(const std::string& name);
  PgConnection& connected();  // with the locks of all that is held; throws PgFailure
  // Of one statement about a bucket, its boolean; on another connection if this one turns out to be lost.
  Result<bool> ask(const char* sql, std::size_t bucket);

  const std::string database_;
  std::mutex mutex_;  // of all below; not held while work() runs
  std::unique_ptr<PgConnection> connection_;
  SteadyTime failed_{};
  std::array<std::size_t, kBuckets> held_{};  // reservations of this process
  std::array<bool, kBuckets> shared_{};       // whether the connection shares the lock
};

}  // namespace meshgauge::server::store
