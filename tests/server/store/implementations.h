// The implementations that every test of the interfaces runs over: TEST_CASE_TEMPLATE("...", Stores,
// EVERY_IMPLEMENTATION).
//
// Each is a class whose objects begin empty, with jobs(), batches(), meshes(), blobs() and reopen(), which is a restart
// of the service in good order.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <doctest/doctest.h>

#include "api/digest.h"
#include "server/store/embedded.h"

#define EVERY_IMPLEMENTATION EmbeddedForTests

namespace meshgauge::server::store {

// A folder of its own that is gone with the object.
class TestFolder {
 public:
  TestFolder() : path_(std::filesystem::temp_directory_path() / ("meshgauge-store-" + api::random_id())) {
    std::filesystem::create_directory(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

// The value, or the end of the test with the error's text.
template <class T>
T got(Result<T> result) {
  if (!result) FAIL(result.error().message);
  return std::move(*result);
}

class EmbeddedForTests {
 public:
  EmbeddedForTests() { reopen(); }

  JobStore& jobs() { return stores_->jobs(); }
  MeshIndex& meshes() { return stores_->meshes(); }
  BatchStore& batches() { return stores_->batches(); }
  BlobStore& blobs() { return stores_->blobs(); }
  void reopen() {
    stores_.reset();
    stores_ = got(EmbeddedStores::open({folder_ / "data", 50}));
  }
  const TestFolder& folder() const { return folder_; }

 private:
  TestFolder folder_;
  std::unique_ptr<EmbeddedStores> stores_;
};

inline TimePoint at(std::int64_t seconds) { return TimePoint(std::chrono::seconds(1'700'000'000 + seconds)); }

inline NewJob new_job(const std::string& owner, const std::string& id) {
  NewJob job;
  job.key = {owner, id};
  job.mesh_a = std::string(64, 'a');
  job.mesh_b = std::string(64, 'b');
  job.hints = R"({"a":"α.stl"})";
  job.options = R"({"tolerance":{"absolute":0.1}})";
  job.cost = 1000;
  job.fingerprint = "print of " + id;
  job.trace = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
  job.created = at(0);
  job.expires_if_never_run = at(3600);
  return job;
}

inline Job ended_job(const std::string& owner, const std::string& id, TimePoint finished = at(10)) {
  Job job;
  static_cast<NewJob&>(job) = new_job(owner, id);
  job.state = JobState::done;
  job.tries = 1;
  job.started = at(5);
  job.finished = finished;
  job.expires = at(1000);
  job.document = R"({"status":"converged"})";
  return job;
}

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

inline BlobKey key_of(const std::string& owner, std::string_view content) {
  return {owner, api::sha256_hex(bytes_of(content))};
}

inline std::string text_of(const Blob& blob) {
  return {reinterpret_cast<const char*>(blob.bytes().data()), blob.bytes().size()};
}

}  // namespace meshgauge::server::store

TYPE_TO_STRING_AS("embedded", meshgauge::server::store::EmbeddedForTests);
