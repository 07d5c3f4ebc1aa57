// PostgresStore: Listings.
#include "server/store/listed_rows.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {

Result<std::vector<MeshRow>> PostgresStore::list_meshes(const Page& page) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return store::list_meshes(connection, page); });
}

Result<std::vector<ListedJob>> PostgresStore::list_jobs(const Page& page) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return store::list_jobs(connection, page); });
}

Result<std::vector<ListedBatch>> PostgresStore::list_batches(const Page& page) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return store::list_batches(connection, page); });
}

Result<JobsOfOwner> PostgresStore::jobs_owned(const std::string& owner) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return count_jobs_of(connection, owner); });
}

Result<std::uint64_t> PostgresStore::batches_owned(const std::string& owner) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return count_batches_of(connection, owner); });
}

}  // namespace meshgauge::server::store
