#include "server/store/postgres/pg_blobs.h"

#include <algorithm>
#include <limits>
#include <set>

#include "api/base/digest.h"
#include "server/store/rows.h"

namespace meshgauge::server::store {
namespace {

constexpr std::int64_t kChunkPortion = 16;  // chunks that one transaction removes
constexpr std::int64_t kBlobsAtOnce = 1000;
constexpr int kSends = 3;  // attempts to send a blob; the database may lose chunks of each

// The database's clock, in milliseconds since 1970.
constexpr Sql kNow("(extract(epoch FROM clock_timestamp()) * 1000)::int8");

constexpr auto kRenewBlob =
    "UPDATE blobs SET renewed = greatest(renewed, " + kNow + ") WHERE owner = $1 AND id = $2 AND upload = $3";
constexpr auto kPutBlob = R"sql(
    INSERT INTO blobs (owner, id, bytes, upload, renewed)
    VALUES ($1, $2, $3, $4, )sql" +
                          kNow + R"sql()
    ON CONFLICT (owner, id) DO UPDATE SET
      bytes = excluded.bytes, upload = excluded.upload, renewed = excluded.renewed)sql";
constexpr auto kRemoveBlob = R"sql(
    DELETE FROM blobs
    WHERE owner = $1 AND id = $2
      AND ($3 < 0 OR (renewed <= )sql" +
                             kNow + " - $3 AND NOT" + kBlobIsUsed + R"sql())
    RETURNING upload, bytes)sql";
constexpr auto kOlderBlobs = R"sql(
    SELECT owner, id FROM blobs
    WHERE (owner, id) > ($1, $2) AND renewed <= )sql" +
                             kNow + R"sql( - $3
    ORDER BY owner, id LIMIT $4)sql";
constexpr auto kBeginUpload = "INSERT INTO blob_uploads VALUES ($1, " + kNow + ") ON CONFLICT DO NOTHING";
constexpr auto kCheck =
    "INSERT INTO checks VALUES ('blobs', " + kNow + ") ON CONFLICT (process) DO UPDATE SET at = excluded.at";
// An upload with begun = 0 can no longer become a blob.
constexpr auto kGiveUpUploads = "UPDATE blob_uploads SET begun = 0 WHERE begun <= " + kNow + " - $1 RETURNING upload";

struct Row {
  std::string upload;
  std::uint64_t bytes = 0;
};

std::optional<Row> find(PgConnection& connection, const BlobKey& key) {
  PgRows row = connection.query("SELECT upload, bytes FROM blobs WHERE owner = $1 AND id = $2", key.owner, key.id);
  if (!row.next()) return std::nullopt;
  return Row{row.text(0), static_cast<std::uint64_t>(row.number(1))};
}

// The order of locks: an owner's sum before its blobs.
void lock_sum(PgConnection& connection, const std::string& owner) {
  connection.query("INSERT INTO blob_bytes VALUES ($1, 0) ON CONFLICT DO NOTHING", owner);
  connection.query("SELECT bytes FROM blob_bytes WHERE owner = $1 FOR UPDATE", owner);
}

void add_to_sum(PgConnection& connection, const std::string& owner, std::int64_t bytes) {
  connection.query("UPDATE blob_bytes SET bytes = bytes + $2 WHERE owner = $1", owner, bytes);
}

void make_garbage(PgConnection& connection, const std::string& upload) {
  connection.query("INSERT INTO blob_uploads VALUES ($1, 0) ON CONFLICT (upload) DO UPDATE SET begun = 0", upload);
}

bool holds(PgConnection& connection, const Row& row, const std::vector<std::string>& digests) {
  PgRows stored = connection.query(
      "SELECT encode(sha256(bytes), 'hex') FROM blob_chunks WHERE upload = $1 ORDER BY position", row.upload);
  std::size_t chunk = 0;
  for (; stored.next(); ++chunk) {
    if (chunk == digests.size() || stored.bytes(0) != digests[chunk]) return false;
  }
  return chunk == digests.size();
}

bool renew_row(PgConnection& connection, const BlobKey& key, const std::string& upload) {
  return connection.query(kRenewBlob, key.owner, key.id, upload).changed() == 1;
}

// No chunk's commit waited for a disk, so a database that crashed may lack chunks, or the upload's row.
bool is_whole(PgConnection& connection, const std::string& upload, std::uint64_t bytes) {
  PgRows sent = connection.query(R"sql(
    SELECT count(*), coalesce(sum(length(bytes)), 0)::int8, EXISTS (SELECT FROM blob_uploads WHERE upload = $1)
    FROM blob_chunks WHERE upload = $1)sql",
                                 upload);
  const std::uint64_t chunks = (bytes + PgBlobs::kChunk - 1) / PgBlobs::kChunk;
  return sent.next() && static_cast<std::uint64_t>(sent.number(0)) == chunks &&
         static_cast<std::uint64_t>(sent.number(1)) == bytes && sent.number(2) != 0;
}

// Makes the upload the blob, in place of a damaged one. `existed`: another upload was faster. nullopt: the database
// lost chunks. In both cases the upload is garbage.
std::optional<BlobPut> settle(PgConnection& connection, const BlobKey& key, const std::string& upload,
                              std::uint64_t bytes, const std::string& damaged) {
  PgTransaction transaction(connection);
  lock_sum(connection, key.owner);
  const std::optional<Row> there = find(connection, key);
  if (there && there->upload == upload) return BlobPut::created;  // an earlier try's commit was not acknowledged
  std::optional<BlobPut> put = BlobPut::created;
  if (there && there->upload != damaged) {
    make_garbage(connection, upload);
    renew_row(connection, key, there->upload);
    put = BlobPut::existed;
  } else if (!is_whole(connection, upload, bytes)) {
    make_garbage(connection, upload);
    put.reset();
  } else {
    if (there) make_garbage(connection, there->upload);
    connection.query(kPutBlob, key.owner, key.id, bytes, upload);
    if (connection.query("DELETE FROM blob_uploads WHERE upload = $1 AND begun > 0", upload).changed() == 0) {
      throw PgFailure{"57014", "the upload took longer than a day and was given up; send it again", false, false};
    }
    add_to_sum(connection, key.owner,
               static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(there ? there->bytes : 0));
  }
  transaction.commit();
  return put;
}

// Removes the blob's row and returns its upload, whose chunks are garbage then. nullopt: there is no such blob, or an
// age is given and the blob is younger or used by a mesh or a job.
std::optional<std::string> remove_row(PgConnection& connection, const BlobKey& key,
                                      std::optional<std::chrono::seconds> older_than) {
  PgTransaction transaction(connection);
  lock_sum(connection, key.owner);
  const std::int64_t age_ms = older_than ? std::chrono::milliseconds(*older_than).count() : -1;
  PgRows row = connection.query(kRemoveBlob, key.owner, key.id, age_ms);
  if (!row.next()) return std::nullopt;
  const std::string upload = row.text(0);
  add_to_sum(connection, key.owner, -row.number(1));
  make_garbage(connection, upload);
  transaction.commit();
  return upload;
}

std::vector<std::string> digests_of_chunks(std::span<const std::byte> bytes) {
  std::vector<std::string> digests;
  for (std::size_t offset = 0; offset < bytes.size(); offset += PgBlobs::kChunk) {
    digests.push_back(api::sha256_hex(bytes.subspan(offset, std::min(PgBlobs::kChunk, bytes.size() - offset))));
  }
  return digests;
}

// The error for a missing chunk. A damaged blob stays damaged until it is put again.
Error not_whole(bool still_there) {
  if (still_there)
    return {ErrorCode::internal, "the stored mesh is damaged: some of its bytes are missing; upload it again", "", ""};
  return {ErrorCode::storage_unavailable, "the stored mesh was removed while it was read; try again", "", ""};
}

}  // namespace

Result<BlobPut> PgBlobs::put(const BlobKey& key, std::span<const std::byte> bytes) {
  if (api::sha256_hex(bytes) != key.id) return BlobPut::other_digest;
  const std::vector<std::string> wanted = digests_of_chunks(bytes);
  std::string damaged;
  const Result<bool> renewed = pool_.run(
      Promise::durable,
      [&](PgConnection& connection) {
        const std::optional<Row> there = find(connection, key);
        if (!there) return false;
        if (there->bytes == bytes.size() && holds(connection, *there, wanted)) {
          return renew_row(connection, key, there->upload);
        }
        damaged = there->upload;
        return false;
      },
      kLonger);
  if (!renewed) return renewed.error();
  if (*renewed) return BlobPut::existed;
  return put_anew(key, bytes, damaged);
}

Result<BlobPut> PgBlobs::put_anew(const BlobKey& key, std::span<const std::byte> bytes, const std::string& damaged) {
  for (int sends = 0; sends < kSends; ++sends) {
    Result<std::optional<BlobPut>> put = put_once(key, bytes, damaged);
    if (!put) return put.error();
    if (*put) return **put;
  }
  return Error{ErrorCode::storage_unavailable, "the database lost parts of the mesh while it was stored; send it again",
               "", ""};
}

Result<std::optional<BlobPut>> PgBlobs::put_once(const BlobKey& key, std::span<const std::byte> bytes,
                                                 const std::string& damaged) {
  const std::string upload = api::random_id();
  if (const Result<Done> sent = send(bytes, upload); !sent) return sent.error();
  const Result<std::optional<BlobPut>> put = pool_.run(Promise::durable, [&](PgConnection& connection) {
    return settle(connection, key, upload, bytes.size(), damaged);
  });
  // Removes what became no blob, or leaves it to remove_garbage(). Not after an error, which may hide a commit.
  const bool created = put && *put == BlobPut::created;
  if (put && !created) static_cast<void>(remove_chunks(upload));
  if (created && !damaged.empty()) static_cast<void>(remove_chunks(damaged));
  return put;
}

Result<Done> PgBlobs::send(std::span<const std::byte> bytes, const std::string& upload) {
  const auto begun = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    connection.query(kBeginUpload, upload);
    return Done{};
  });
  if (!begun) return begun.error();
  std::int64_t position = 0;
  for (std::size_t offset = 0; offset < bytes.size(); offset += kChunk, ++position) {
    const std::span<const std::byte> piece = bytes.subspan(offset, std::min(kChunk, bytes.size() - offset));
    // None of these commits waits for a disk: the one that makes them a blob waits for all. Chunks need the upload's
    // row, by which remove_garbage() finds them.
    const auto sent = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
      connection.query(R"sql(
    WITH stored AS (
      INSERT INTO blob_chunks
      SELECT $1, $2, $3 WHERE EXISTS (SELECT FROM blob_uploads WHERE upload = $1)
      ON CONFLICT DO NOTHING
      RETURNING 1)
    SELECT set_config('synchronous_commit', 'off', true) FROM stored)sql",
                       upload, position, piece);
      return Done{};
    });
    if (!sent) return sent.error();
  }
  return Done{};
}

Result<bool> PgBlobs::fetch(const BlobKey& key, const Take& take) {
  const auto row = pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find(connection, key); });
  if (!row) return row.error();
  if (!*row) return false;
  std::uint64_t fetched = 0;
  for (std::int64_t position = 0; fetched < (*row)->bytes; ++position) {
    bool still_there = false;
    const Result<std::string> chunk = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
      PgRows found = connection.query("SELECT bytes FROM blob_chunks WHERE upload = $1 AND position = $2",
                                      (*row)->upload, position);
      if (found.next()) return found.text(0);
      const std::optional<Row> now = find(connection, key);
      still_there = now && now->upload == (*row)->upload;
      return std::string();
    });
    if (!chunk) return chunk.error();
    if (chunk->empty()) return not_whole(still_there);
    const Result<Done> taken = take(std::as_bytes(std::span(*chunk)));
    if (!taken) return taken.error();
    fetched += chunk->size();
  }
  return true;
}

Result<bool> PgBlobs::exists(const BlobKey& key) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) { return find(connection, key).has_value(); });
}

Result<bool> PgBlobs::renew(const BlobKey& key) {
  return pool_.run(Promise::durable, [&](PgConnection& connection) {
    const std::optional<Row> there = find(connection, key);
    return there && renew_row(connection, key, there->upload);
  });
}

Result<bool> PgBlobs::remove(const BlobKey& key) {
  const auto upload =
      pool_.run(Promise::durable, [&](PgConnection& connection) { return remove_row(connection, key, std::nullopt); });
  if (!upload) return upload.error();
  if (*upload) static_cast<void>(remove_chunks(**upload));  // on an error remove_garbage() does it
  return upload->has_value();
}

// The chunks are removed after unless_held(), so no reservation waits for that.
Result<bool> PgBlobs::remove_if_old(const BlobKey& key, std::chrono::seconds older_than, Reservations& reservations) {
  std::string garbage;
  Result<bool> removed = reservations.unless_held(blob_name(key), [&]() -> Result<bool> {
    auto upload =
        pool_.run(Promise::durable, [&](PgConnection& connection) { return remove_row(connection, key, older_than); });
    if (!upload) return upload.error();
    if (*upload) garbage = **upload;
    return upload->has_value();
  });
  if (removed && *removed) static_cast<void>(remove_chunks(garbage));  // on an error remove_garbage() does it
  return removed;
}

// Precondition: the upload is garbage.
Result<Done> PgBlobs::remove_chunks(const std::string& upload) {
  while (true) {
    const auto removed = pool_.run(
        Promise::fleeting,
        [&](PgConnection& connection) {
          const std::uint64_t chunks = connection
                                           .query(R"sql(
    DELETE FROM blob_chunks
    WHERE upload = $1 AND position IN (SELECT position FROM blob_chunks WHERE upload = $1 LIMIT $2))sql",
                                                  upload, kChunkPortion)
                                           .changed();
          if (chunks == 0) connection.query("DELETE FROM blob_uploads WHERE upload = $1", upload);
          return chunks;
        },
        kLonger);
    if (!removed) return removed.error();
    if (*removed == 0) return Done{};
  }
}

Result<Done> PgBlobs::remove_garbage() {
  const auto uploads = pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    PgRows row = connection.query(kGiveUpUploads, std::chrono::milliseconds(kAbandoned).count());
    std::vector<std::string> found;
    while (row.next()) found.push_back(row.text(0));
    return found;
  });
  if (!uploads) return uploads.error();
  for (const std::string& upload : *uploads) {
    Result<Done> removed = remove_chunks(upload);
    if (!removed) return removed;
  }
  return Done{};
}

Result<std::vector<BlobKey>> PgBlobs::unused(std::span<const BlobKey> used, std::chrono::seconds older_than) {
  std::set<std::pair<std::string_view, std::string_view>> kept;
  for (const BlobKey& key : used) kept.emplace(key.owner, key.id);
  const std::int64_t older_than_ms = std::chrono::milliseconds(older_than).count();
  std::vector<BlobKey> found;
  BlobKey after;
  while (true) {
    const auto keys = pool_.run(
        Promise::fleeting,
        [&](PgConnection& connection) {
          return keys_of<BlobKey>(connection.query(kOlderBlobs, after.owner, after.id, older_than_ms, kBlobsAtOnce));
        },
        kLonger);
    if (!keys) return keys.error();
    if (keys->empty()) return found;
    for (const BlobKey& key : *keys) {
      if (!kept.contains({key.owner, key.id})) found.push_back(key);
    }
    after = keys->back();
  }
}

Result<std::uint64_t> PgBlobs::remove_unused(std::span<const BlobKey> used, std::chrono::seconds older_than,
                                             Reservations& reservations) {
  const auto found = unused(used, older_than);
  if (!found) return found.error();
  std::uint64_t removed = 0;
  for (const BlobKey& key : *found) {
    const Result<bool> gone = remove_if_old(key, older_than, reservations);
    if (!gone) return gone.error();
    if (*gone) ++removed;
  }
  const Result<Done> cleared = remove_garbage();
  if (!cleared) return cleared.error();
  return removed;
}

Result<std::uint64_t> PgBlobs::stored_bytes(const std::string& owner) {
  return pool_.run(Promise::fleeting, [&](PgConnection& connection) {
    return only_count(connection.query("SELECT bytes FROM blob_bytes WHERE owner = $1", owner));
  });
}

Result<std::uint64_t> PgBlobs::free_bytes() { return std::numeric_limits<std::uint64_t>::max(); }

Result<Done> PgBlobs::check() {
  return pool_.run(Promise::durable, [](PgConnection& connection) {
    connection.query(kCheck);
    return Done{};
  });
}

}  // namespace meshgauge::server::store
