// SqliteStore: MeshIndex.
#include <set>

#include "server/store/sqlite_store.h"

namespace meshgauge::server::store {
namespace {

std::optional<MeshRow> find_mesh(Connection& connection, const BlobKey& key) {
  Query row(connection,
            "SELECT bytes, media_type, file_name, created, last_used, expires FROM meshes WHERE owner = ? AND id = ?",
            key.owner, key.id);
  if (!row.next()) return std::nullopt;
  return MeshRow{
      key, static_cast<std::uint64_t>(row.number(0)), row.text(1), row.text(2), row.time(3), row.time(4), row.time(5)};
}

std::uint64_t stored_by(Connection& connection, const std::string& owner) {
  Query row(connection, "SELECT bytes FROM stored WHERE owner = ?", owner);
  return row.next() ? static_cast<std::uint64_t>(row.number(0)) : 0;
}

void use_mesh(Connection& connection, const BlobKey& key, TimePoint last_used, TimePoint expires) {
  Query(connection,
        "UPDATE meshes SET last_used = max(last_used, ?), expires = max(expires, ?) WHERE owner = ? AND id = ?",
        last_used, expires, key.owner, key.id)
      .run();
}

PutMesh put_again(Connection& connection, const MeshRow& row) {
  use_mesh(connection, row.key, row.last_used, row.expires);
  return {MeshPut::existed, *find_mesh(connection, row.key)};
}

}  // namespace

Result<PutMesh> SqliteStore::put_mesh(const MeshRow& row, std::uint64_t max_stored_bytes) {
  return writer_.write([&](Connection& connection) {
    if (find_mesh(connection, row.key)) return put_again(connection, row);
    const std::uint64_t stored = stored_by(connection, row.key.owner);
    if (row.bytes > max_stored_bytes || stored > max_stored_bytes - row.bytes) return PutMesh{MeshPut::over_quota, row};
    Query(connection, "INSERT INTO meshes VALUES (?, ?, ?, ?, ?, ?, ?, ?)", row.key.owner, row.key.id, row.bytes,
          row.media_type, row.file_name, row.created, row.last_used, row.expires)
        .run();
    return PutMesh{MeshPut::created, row};
  });
}

Result<std::optional<MeshRow>> SqliteStore::get_mesh(const BlobKey& key) {
  return readers_.read([&](Connection& connection) { return find_mesh(connection, key); });
}

Result<std::vector<MeshRow>> SqliteStore::known_meshes(const std::string& owner, std::span<const std::string> ids) {
  return readers_.read([&](Connection& connection) {
    std::vector<MeshRow> known;
    for (const std::string& id : std::set<std::string>(ids.begin(), ids.end())) {
      if (std::optional<MeshRow> row = find_mesh(connection, {owner, id})) known.push_back(*std::move(row));
    }
    return known;
  });
}

Result<bool> SqliteStore::delete_mesh(const BlobKey& key) {
  return writer_.write([&](Connection& connection) {
    return Query(connection, "DELETE FROM meshes WHERE owner = ? AND id = ?", key.owner, key.id).run() == 1;
  });
}

Result<std::uint64_t> SqliteStore::stored_bytes(const std::string& owner) {
  return readers_.read([&](Connection& connection) { return stored_by(connection, owner); });
}

Result<std::uint64_t> SqliteStore::all_stored_bytes() {
  return readers_.read([](Connection& connection) {
    Query query(connection, "SELECT coalesce(sum(bytes), 0) FROM stored");
    query.next();
    return static_cast<std::uint64_t>(query.number(0));
  });
}

Result<std::uint64_t> SqliteStore::sweep_meshes(TimePoint now) {
  Result<Done> flushed = flush();  // a mesh that was just used stays
  if (!flushed) return flushed.error();
  return remove_in_portions([now](Connection& connection, std::int64_t most) {
    return Query(connection,
                 "DELETE FROM meshes WHERE (owner, id) IN (SELECT owner, id FROM meshes WHERE expires <= ? LIMIT ?)",
                 now, most)
        .run();
  });
}

}  // namespace meshgauge::server::store
