// BlobStore in files:
//
//   <root>/incoming/<random>                                  being written; removed at the start
//   <root>/<SHA-256 of the owner>/<first two digits>/<id>     complete, synced, never changed
//
// No name from outside becomes part of a path: owners are hashed, and an id has 64 hex digits or names no blob.
// data_folder.h has the modes. A file's time of modification is when it was last put or renewed.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include "server/store/blob_store.h"
#include "server/store/reserve.h"

namespace meshgauge::server::store {

class FileBlobs final : public BlobStore {
 public:
  // Creates `root` if needed. No other object may use it (DataFolder ensures that). Borrows the reserve, whose room
  // put() leaves alone; null: there is none.
  static Result<std::unique_ptr<FileBlobs>> open(const std::string& root, Reserve* reserve = nullptr);

  Result<BlobPut> put(const BlobKey& key, std::span<const std::byte> bytes) override;
  Result<std::optional<Blob>> open(const BlobKey& key) override;
  Result<bool> exists(const BlobKey& key) override;
  Result<bool> renew(const BlobKey& key) override;
  Result<bool> remove(const BlobKey& key) override;
  Result<UnusedBlobs> count_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override;
  Result<std::uint64_t> remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than) override;
  Result<std::uint64_t> stored_bytes(const std::string& owner) override;
  Result<std::uint64_t> free_bytes() override;
  Result<Done> check() override;

 private:
  struct Place;

  FileBlobs(std::string root, Reserve* reserve) : root_(std::move(root)), reserve_(reserve) {}

  Place place_of(const BlobKey& key) const;
  Result<Done> prepare();
  Result<bool> put_again(const Place& place, std::span<const std::byte> bytes);
  Result<Done> put_anew(const Place& place, std::span<const std::byte> bytes);
  Result<Done> move_in(const std::string& incoming, const Place& place);
  Result<Done> make_durable_folder(const std::string& path, const std::string& around);
  Result<bool> renew(const Place& place);
  std::mutex& lock_of(const std::string& path);
  Result<Done> weigh();
  template <class Visit>
  std::error_code for_each_unused(std::span<const BlobKey> used, std::chrono::seconds older_than, Visit visit);
  bool unlink(const std::string& path);
  void count(const std::string& path, std::uint64_t before, std::uint64_t after);

  const std::string root_;
  Reserve* const reserve_;
  // Excludes a blob's removal while the blob is put or renewed.
  std::array<std::mutex, 64> locks_;
  std::mutex bytes_mutex_;
  std::unordered_map<std::string, std::uint64_t> bytes_;  // by folder of the owner
  std::mutex folders_mutex_;
  std::unordered_set<std::string> durable_folders_;  // this object has synced their names
};

}  // namespace meshgauge::server::store
