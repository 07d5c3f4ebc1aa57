// The suites of the interfaces over PostgreSQL: an implementation as implementations.h says, each object a database of
// its own on the server of this run.
#pragma once

#include "postgres_server.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {

class PostgresForTests {
 public:
  static constexpr bool kListsRecovered = false;  // jobs are claimed by claim_some() alone

  PostgresForTests() : database_(PostgresServer::shared().new_database()) { reopen(); }
  ~PostgresForTests() {
    store_.reset();
    PostgresServer::shared().drop(database_);
  }
  PostgresForTests(const PostgresForTests&) = delete;
  PostgresForTests& operator=(const PostgresForTests&) = delete;

  JobStore& jobs() { return *store_; }
  MeshIndex& meshes() { return *store_; }
  BatchStore& batches() { return *store_; }
  PartStore& parts() { return *store_; }
  PostgresStore& store() { return *store_; }
  JobStore& blobs() { return *store_; }
  void reopen() {
    store_.reset();
    store_ = open();
  }
  std::unique_ptr<PostgresStore> open() const { return got(PostgresStore::open(settings())); }  // another process
  PostgresSettings settings() const {
    PostgresSettings settings;
    settings.database = database_;
    settings.max_unrecorded = 50;
    return settings;
  }

 private:
  const std::string database_;
  std::unique_ptr<PostgresStore> store_;
};

}  // namespace meshgauge::server::store

TYPE_TO_STRING_AS("PostgreSQL", meshgauge::server::store::PostgresForTests);
