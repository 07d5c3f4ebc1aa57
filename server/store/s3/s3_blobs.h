// Blobs in a bucket of a service with the S3 API:
//
//   PREFIX/<SHA-256 of the owner>/<first two digits>/<id>     an object appears complete, or not at all
//   PREFIX/check                                              written by check()
//
// Requests are signed with the SHA-256 of the body, which is the blob's id, and send it as x-amz-checksum-sha256 too:
// so the server can refuse other bytes. Large blobs go in parts, several at once, each signed with its own digest. An
// object's time of modification, by the server's clock, is when it was last put or renewed.
//
// The server must be strongly consistent: a read that begins after a put sees it (S3 is since 2020).
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/result.h"
#include "server/store/remote_blobs.h"
#include "server/store/s3/client.h"

namespace meshgauge::server::store {

// The bytes of each owner's blobs, where only a listing tells them. An owner is listed once; then this process adds
// what it puts and subtracts what it removes, and lists again in the background for the changes of other processes.
//
// Error bound: a sum lacks at most what other processes have put since its listing, which is at most kAge old, or kIdle
// times as long as a listing takes. It may be too large for as long: blobs put or removed during a listing count as
// present.
//
// Thread safe. The destructor waits for a listing in the background.
class OwnerSums {
 public:
  using Weigh = std::function<Result<std::uint64_t>(const std::string& owner)>;
  static constexpr std::chrono::seconds kAge{60};
  static constexpr int kIdle = 20;

  explicit OwnerSums(Weigh weigh, std::chrono::milliseconds age = kAge) : weigh_(std::move(weigh)), age_(age) {}

  ~OwnerSums();
  OwnerSums(const OwnerSums&) = delete;
  OwnerSums& operator=(const OwnerSums&) = delete;

  // Blocks for a listing at the first call for an owner.
  Result<std::uint64_t> of(const std::string& owner);
  void add(const std::string& owner, std::uint64_t bytes);     // call it after the put
  void remove(const std::string& owner, std::uint64_t bytes);  // call it before the removal; add() if that fails

 private:
  using Clock = std::chrono::steady_clock;
  struct Sum {
    bool known = false;
    bool weighing = false;
    std::uint64_t bytes = 0;
    std::uint64_t meanwhile = 0;  // bytes added since the listing began
    Clock::time_point good_until{};
    std::future<void> refresh;
  };

  Result<std::uint64_t> weigh(const std::string& owner);
  Result<std::uint64_t> weighed(const std::string& owner) const;

  const Weigh weigh_;
  const std::chrono::milliseconds age_;
  std::mutex mutex_;
  std::condition_variable weighed_;
  std::unordered_map<std::string, Sum> sums_;  // a node container: elements keep their addresses
};

struct S3BlobOptions {
  std::uint64_t in_parts_from = std::uint64_t{64} << 20;  // larger blobs are sent in parts
  std::uint64_t part_bytes = std::uint64_t{32} << 20;     // S3 allows 5 MiB and more, and 10,000 parts
  unsigned parts_at_once = 4;                             // of one upload, each on a connection of its own
  // A blob that was put or renewed within this time is not renewed again, and remove_unused() waits that much longer.
  // So a mesh that many jobs use at once is not copied for each.
  std::chrono::seconds young{300};
  std::chrono::seconds abandoned{24 * 3600};  // remove_unused() aborts uploads in parts that began earlier
  unsigned removals_at_once = 8;
  std::chrono::milliseconds sum_age = OwnerSums::kAge;
};

// The largest object that S3 copies in one request; renew() copies.
inline constexpr std::uint64_t kMaxS3Blob = std::uint64_t{5} << 30;

class S3Blobs final : public RemoteBlobs {
 public:
  explicit S3Blobs(S3Settings settings, S3BlobOptions options = {}, S3Limits limits = {}, Report report = {});

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<bool> fetch(const BlobKey& key, const Take& take) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
  Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override;
  Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                      Reservations& reservations) override;
  Result<std::uint64_t> stored_bytes(const std::string& owner) override;  // within the error bound of OwnerSums
  Result<std::uint64_t> free_bytes() override;                            // unknown
  Result<Done> check() override;

 private:
  std::string object_of(const std::string& name) const { return root_ + name; }

  template <class Visit>
  Result<Done> for_each_unused(std::span<const BlobKey> used, std::chrono::seconds limit, Visit visit);
  Result<Done> send(const BlobKey& key, std::span<const std::byte> bytes, const std::string& etag_before);
  Result<Done> check_completed(const std::string& object, std::uint64_t size, const std::string& not_etag);
  Result<bool> send_parts(const BlobKey& key, const std::string& upload, std::span<const std::byte> bytes);
  Result<bool> renew(const std::string& object, const S3Object& found);
  Result<bool> remove_found(const std::string& name, const S3Object& found);
  Result<bool> remove_if_old(const std::string& name, std::chrono::seconds older_than, Reservations& reservations);
  Result<std::uint64_t> remove_listed(const std::vector<std::string>& names, std::chrono::seconds older_than,
                                      Reservations& reservations);
  Result<Done> abort_abandoned();
  Result<std::uint64_t> weigh(const std::string& owner);

  const S3BlobOptions options_;
  S3Client client_;
  const std::string root_;  // "PREFIX/" or ""
  OwnerSums sums_;          // by the hash of the owner; destroyed first: it may be listing
};

}  // namespace meshgauge::server::store
