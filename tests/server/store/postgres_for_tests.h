// The suites of the interfaces over PostgreSQL: an implementation as implementations.h says, each object a database of
// its own on the server of this run.
#pragma once

#include <memory>
#include <string>

#include <doctest/doctest.h>

#include "server/store/forms/stores.h"
#include "tests/server/store/postgres_server.h"
#include "tests/server/store/store_text.h"
#include "tests/server/store/test_folder.h"

namespace meshgauge::server::store {

class PostgresForTests {
 public:
  static constexpr bool kListsRecovered = false;  // jobs are claimed by claim_some() alone

  PostgresForTests() : database_(PostgresServer::shared().new_database()) { reopen(); }
  ~PostgresForTests() {
    stores_.reset();
    PostgresServer::shared().drop(database_);
  }
  PostgresForTests(const PostgresForTests&) = delete;
  PostgresForTests& operator=(const PostgresForTests&) = delete;

  JobStore& jobs() { return stores_->jobs(); }
  MeshIndex& meshes() { return stores_->meshes(); }
  BatchStore& batches() { return stores_->batches(); }
  Listings& listings() { return stores_->listings(); }
  BlobStore& blobs() { return stores_->blobs(); }
  Signals& signals() { return stores_->signals(); }
  void reopen() {
    stores_.reset();
    stores_ = open("own");
  }
  const std::string& database() const { return database_; }

  // Another process, with a folder of that name.
  std::unique_ptr<AllStores> open(const std::string& folder) const {
    return got(AllStores::open_distributed(settings(folder)));
  }
  DistributedSettings settings(const std::string& folder) const {
    DistributedSettings settings;
    settings.database = database_;
    settings.data_folder = folder_ / folder;
    settings.max_unrecorded = 50;
    settings.call_timeout = std::chrono::seconds(20);  // a slow machine is no failure
    settings.duty_grace = std::chrono::milliseconds(300);
    return settings;
  }

 private:
  const std::string database_;
  TestFolder folder_;
  std::unique_ptr<AllStores> stores_;
};

}  // namespace meshgauge::server::store

TYPE_TO_STRING_AS("PostgreSQL", meshgauge::server::store::PostgresForTests);
