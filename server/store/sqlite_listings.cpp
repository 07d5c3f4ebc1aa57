// SqliteStore: Listings.
#include "server/store/listed_rows.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {

Result<std::vector<MeshRow>> SqliteStore::list_meshes(const Page& page) {
  return readers_.read([&](Connection& connection) { return store::list_meshes(connection, page); });
}

Result<std::vector<ListedJob>> SqliteStore::list_jobs(const Page& page) {
  return readers_.read([&](Connection& connection) { return store::list_jobs(connection, page); });
}

Result<std::vector<ListedBatch>> SqliteStore::list_batches(const Page& page) {
  return readers_.read([&](Connection& connection) { return store::list_batches(connection, page); });
}

Result<JobsOfOwner> SqliteStore::jobs_owned(const std::string& owner) {
  return readers_.read([&](Connection& connection) { return count_jobs_of(connection, owner); });
}

Result<std::uint64_t> SqliteStore::batches_owned(const std::string& owner) {
  return readers_.read([&](Connection& connection) { return count_batches_of(connection, owner); });
}

}  // namespace meshgauge::server::store
