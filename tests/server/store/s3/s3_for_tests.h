// Blobs in S3 behind a cache, for the suite of BlobStore: those of the double, or of the server that the variable
// MESHGAUGE_TEST_S3 names (an endpoint; then MESHGAUGE_TEST_S3_BLOBS is s3://BUCKET/PREFIX, and AWS_* the credentials).
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include <doctest/doctest.h>

#include "../test_folder.h"
#include "s3_double.h"
#include "server/store/blob_cache.h"
#include "server/store/s3/s3_blobs.h"

namespace meshgauge::server::store {

class S3ForTests {
 public:
  S3ForTests();
  ~S3ForTests();

  BlobStore& blobs() { return *blobs_; }
  void reopen();
  // Long enough for an age to be visible on a clock of whole seconds.
  void pass_time(std::chrono::milliseconds time);

 private:
  TestFolder folder_;
  std::optional<S3Double> double_;
  S3Settings settings_;
  std::unique_ptr<CachedBlobs> blobs_;
};

// A prefix of its own on the real server, or on a double that is started for it.
S3Settings settings_for_tests(std::optional<S3Double>& server);
// Parts of a megabyte; no blob is young.
S3BlobOptions options_for_tests();
// Many attempts, at short intervals.
S3Limits limits_for_tests();

}  // namespace meshgauge::server::store

TYPE_TO_STRING_AS("S3", meshgauge::server::store::S3ForTests);
