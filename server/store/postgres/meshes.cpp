// PostgresStore: MeshIndex.
#include "server/store/postgres/postgres_store.h"
#include "server/store/rows.h"

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kMeshPortion = 500;  // rows that one transaction removes

constexpr auto kUseMesh = R"sql(
    UPDATE meshes SET last_used = greatest(last_used, $3), expires = greatest(expires, $4)
    WHERE owner = $1 AND id = $2
    RETURNING )sql" + kMeshColumns;
constexpr auto kFindMeshes =
    "SELECT " + kMeshColumns + " FROM meshes WHERE owner = $1 AND id IN (SELECT unnest($2::bytea[]))";

// Returns what an owner has stored, locked until the end of the transaction.
StoredMeshes lock_stored(PgConnection& connection, const std::string& owner) {
  connection.query("INSERT INTO stored VALUES ($1, 0) ON CONFLICT DO NOTHING", owner);
  PgRows row = connection.query("SELECT bytes, meshes FROM stored WHERE owner = $1 FOR UPDATE", owner);
  return row.next() ? StoredMeshes{count_in(row, 0), count_in(row, 1)} : StoredMeshes{};
}

PutMesh put(PgConnection& connection, const MeshRow& mesh, const MeshQuota& quota) {
  PgTransaction transaction(connection);
  const StoredMeshes stored = lock_stored(connection, mesh.key.owner);
  auto there = first_mesh(connection.query(kUseMesh, mesh.key.owner, mesh.key.id, mesh.last_used, mesh.expires));
  if (there) {
    transaction.commit();
    return {MeshPut::existed, *std::move(there)};
  }
  const MeshPut what = fits(stored, mesh.bytes, quota);
  if (what != MeshPut::created) return {what, mesh};
  connection.query("INSERT INTO meshes VALUES ($1, $2, $3, $4, $5, $6, $7, $8)", mesh.key.owner, mesh.key.id,
                   mesh.bytes, mesh.media_type, mesh.file_name, mesh.created, mesh.last_used, mesh.expires);
  transaction.commit();
  return {MeshPut::created, mesh};
}

// Removes some expired meshes of one owner; returns their keys. Empty: there are none.
std::vector<BlobKey> remove_expired(PgConnection& connection, TimePoint now) {
  PgTransaction transaction(connection);
  PgRows oldest = connection.query("SELECT owner FROM meshes WHERE expires <= $1 ORDER BY expires LIMIT 1", now);
  if (!oldest.next()) return {};
  const std::string owner = oldest.text(0);
  lock_stored(connection, owner);
  // The first condition is checked again on a row that was locked: a mesh that was just used stays.
  auto removed = keys_of<BlobKey>(connection.query(R"sql(
    DELETE FROM meshes
    WHERE expires <= $2
      AND (owner, id) IN (SELECT owner, id FROM meshes WHERE owner = $1 AND expires <= $2 LIMIT $3)
    RETURNING owner, id)sql",
                                                   owner, now, kMeshPortion));
  transaction.commit();
  return removed;
}

}  // namespace

Result<PutMesh> PostgresStore::put_mesh(const MeshRow& row, const MeshQuota& quota) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) { return put(connection, row, quota); });
}

Result<std::optional<MeshRow>> PostgresStore::get_mesh(const BlobKey& key) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find_mesh(connection, key); });
}

Result<std::vector<MeshRow>> PostgresStore::known_meshes(const std::string& owner, std::span<const std::string> ids) {
  const std::vector<std::string> wanted(ids.begin(), ids.end());
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(kFindMeshes, owner, wanted);
    std::vector<MeshRow> known;
    while (auto mesh = first_mesh(row)) known.push_back(*std::move(mesh));
    return known;
  });
}

Result<bool> PostgresStore::delete_mesh(const BlobKey& key) {
  bool was_there = false;  // also in a try whose commit was not acknowledged
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    // Locks in the order of put_mesh(): first the owner's sum.
    PgTransaction transaction(connection);
    lock_stored(connection, key.owner);
    was_there |= connection.query("DELETE FROM meshes WHERE owner = $1 AND id = $2", key.owner, key.id).changed() == 1;
    transaction.commit();
    return was_there;
  });
}

Result<StoredMeshes> PostgresStore::stored(const std::string& owner) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find_stored(connection, owner); });
}

Result<std::uint64_t> PostgresStore::all_stored_bytes() {
  return pool_.run(Promise::fleeting, count_stored<PgConnection>);
}

// One owner at a time; locks the owner's sum first, as put_mesh() does.
Result<std::vector<BlobKey>> PostgresStore::sweep_meshes(TimePoint now) {
  Result<Done> flushed = flush();  // a mesh that was just used must stay
  if (!flushed) return flushed.error();
  for (std::vector<BlobKey> removed;;) {
    const auto portion =
        pool_.run(Promise::durable, [&](PgConnection& connection) { return remove_expired(connection, now); });
    if (!portion) return portion.error();
    if (portion->empty()) return removed;
    removed.insert(removed.end(), portion->begin(), portion->end());
  }
}

}  // namespace meshgauge::server::store
