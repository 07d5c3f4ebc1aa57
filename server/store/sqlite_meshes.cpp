// SqliteStore: MeshIndex.
#include "server/store/job_rows.h"
#include "server/store/rows.h"
#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {
namespace {

constexpr Sql kRemoveMeshes(R"sql(
    DELETE FROM meshes
    WHERE (owner, id) IN (SELECT owner, id FROM meshes WHERE expires <= $1 LIMIT $2)
    RETURNING owner, id)sql");

}  // namespace

Result<PutMesh> SqliteStore::put_mesh(const MeshRow& row, const MeshQuota& quota) {
  return writer_.write([&](Connection& connection) {
    if (find_mesh(connection, row.key)) {
      use_mesh(connection, row.key, row.last_used, row.expires);
      return PutMesh{MeshPut::existed, *find_mesh(connection, row.key)};
    }
    const MeshPut what = fits(find_stored(connection, row.key.owner), row.bytes, quota);
    if (what != MeshPut::created) return PutMesh{what, row};
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
  return writer_.write(
      [&](Connection& connection) {
        return connection.query("DELETE FROM meshes WHERE owner = $1 AND id = $2", key.owner, key.id).run() == 1;
      },
      Writer::Promise::removal);
}

Result<StoredMeshes> SqliteStore::stored(const std::string& owner) {
  return readers_.read([&](Connection& connection) { return find_stored(connection, owner); });
}

Result<std::uint64_t> SqliteStore::all_stored_bytes() { return readers_.read(count_stored<Connection>); }

// A mesh that was just used must stay, also when a full disk does not take the time of its use.
Result<std::vector<BlobKey>> SqliteStore::sweep_meshes(TimePoint now) {
  const Result<Done> flushed = flush();
  if (!flushed && flushed.error().code != ErrorCode::storage_full) return flushed.error();
  const WriteBehind::Touches touches = flushed ? WriteBehind::Touches() : behind_.touches();
  std::vector<BlobKey> removed;
  const auto swept = remove_in_portions([&](std::int64_t most) -> Result<std::uint64_t> {
    const auto portion = writer_.write(
        [&](Connection& connection) {
          for (const auto& [mesh, touch] : touches) {
            if (touch.expires > now) use_mesh(connection, mesh, touch.last_used, touch.expires);
          }
          return keys_of<BlobKey>(connection.query(kRemoveMeshes, now, most));
        },
        Writer::Promise::removal);
    if (!portion) return portion.error();
    removed.insert(removed.end(), portion->begin(), portion->end());
    return portion->size();
  });
  if (!swept) return swept.error();
  return removed;
}

}  // namespace meshgauge::server::store
