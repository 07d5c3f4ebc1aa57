// SqliteStore: MeshIndex.
#include "server/store/job_rows.h"
#include "server/store/rows.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {
namespace {}  // namespace

Result<PutMesh> SqliteStore::put_mesh(const MeshRow& row, std::uint64_t max_stored_bytes) {
  return writer_.write([&](Connection& connection) {
    if (find_mesh(connection, row.key)) {
      use_mesh(connection, row.key, row.last_used, row.expires);
      return PutMesh{MeshPut::existed, *find_mesh(connection, row.key)};
    }
    const std::uint64_t stored = count_stored_by(connection, row.key.owner);
    if (row.bytes > max_stored_bytes || stored > max_stored_bytes - row.bytes) return PutMesh{MeshPut::over_quota, row};
    connection
        .query("INSERT INTO meshes VALUES ($1, $2, $3, $4, $5, $6, $7, $8)", row.key.owner, row.key.id, row.bytes,
               row.media_type, row.file_name, row.created, row.last_used, row.expires)
        .run();
    return PutMesh{MeshPut::created, row};
  });
}

Result<std::optional<MeshRow>> SqliteStore::get_mesh(const BlobKey& key) {
  return readers_.read([&](Connection& connection) { return find_mesh(connection, key); });
}

Result<bool> SqliteStore::delete_mesh(const BlobKey& key) {
  return writer_.write([&](Connection& connection) {
    return connection.query("DELETE FROM meshes WHERE owner = $1 AND id = $2", key.owner, key.id).run() == 1;
  });
}

Result<std::uint64_t> SqliteStore::stored_bytes(const std::string& owner) {
  return readers_.read([&](Connection& connection) { return count_stored_by(connection, owner); });
}

Result<std::uint64_t> SqliteStore::all_stored_bytes() { return readers_.read(count_stored<Connection>); }

Result<std::uint64_t> SqliteStore::sweep_meshes(TimePoint now) {
  Result<Done> flushed = flush();  // a mesh that was just used must stay
  if (!flushed) return flushed.error();
  return remove_in_portions([now](Connection& connection, std::int64_t most) {
    return connection
        .query(R"sql(
    DELETE FROM meshes
    WHERE (owner, id) IN (SELECT owner, id FROM meshes WHERE expires <= $1 LIMIT $2))sql",
               now, most)
        .run();
  });
}

}  // namespace meshgauge::server::store
