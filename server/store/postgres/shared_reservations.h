// Reservations of blobs (blob_store.h) that all processes of one database share, by advisory locks. Each name is in one
// of 256 buckets, and a process holds a shared lock of a bucket while it has a reservation in it. So ten thousand
// reservations at once cost at most 256 round trips. A blob may look reserved because another one of its bucket is;
// then remove_unused() keeps it.
//
// The locks end with their connection. While the database is away nothing is reserved, and no blob can be removed or
// referred to. A new connection takes the locks again.
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
  PgConnection& connected();  // holds the locks of all reservations; throws PgFailure
  // Returns the boolean of a statement about a bucket; on another connection if this one is lost.
  Result<bool> ask(const char* sql, std::size_t bucket);

  const std::string database_;
  std::mutex mutex_;  // guards the members below; not held while work() runs
  std::unique_ptr<PgConnection> connection_;
  SteadyTime failed_{};
  std::array<std::size_t, kBuckets> held_{};  // reservations of this process
  std::array<bool, kBuckets> shared_{};       // whether the connection holds the lock
};

}  // namespace meshgauge::server::store
