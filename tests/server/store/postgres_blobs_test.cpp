#include "server/store/postgres/pg_blobs.h"

#include <algorithm>
#include <limits>
#include <thread>
#include <utility>

#include "implementations.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
using namespace std::chrono_literals;

namespace {

class Blobs {
 public:
  Blobs()
      : database_(PostgresServer::shared().new_database()),
        connection_(PgConnection::open(database_)),
        pool_({database_, 4, 4000ms}),
        blobs_(pool_) {}
  PgBlobs* operator->() { return &blobs_; }
  void execute(const std::string& sql) { connection_->execute(sql); }
  std::int64_t number(const char* sql) {
    PgRows row = connection_->query(sql);
    REQUIRE(row.next());
    return row.number(0);
  }
  // Loses chunks of the upload that is under way, when `when` is true of a stored chunk: like a database that comes
  // back without its last commits, none of which waited for a disk.
  void lose(const std::string& what, const std::string& when) {
    execute(
        "CREATE SEQUENCE inserts; CREATE FUNCTION lose() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN IF " + when +
        " THEN DELETE FROM " + what +
        " upload = new.upload; END IF; RETURN NULL; END $$; CREATE TRIGGER lose AFTER INSERT ON blob_chunks FOR EACH "
        "ROW EXECUTE FUNCTION lose()");
  }
  // Compares as many bytes as there are.
  Result<bool> read(const BlobKey& key, std::string& into) {
    return blobs_.fetch(key, [&](std::span<const std::byte> piece) {
      into.append(reinterpret_cast<const char*>(piece.data()), piece.size());
      return Result<Done>(Done{});
    });
  }

 private:
  const std::string database_;
  std::unique_ptr<PgConnection> connection_;
  PgPool pool_;
  PgBlobs blobs_;
};

const std::string kText = long_text(3'500'000);

Reservations none_reserved;

}  // namespace

TEST_CASE("PostgreSQL blobs: stored in chunks, which are removed with the blob") {
  Blobs blobs;
  const BlobKey key = key_of("ann", kText);
  CHECK(got(blobs->put(key, bytes_of(kText))) == BlobPut::created);
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 4);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads") == 0);
  CHECK(blobs.number("SELECT sum(length(bytes)) FROM blob_chunks") == 3'500'000);
  std::string read;
  CHECK(got(blobs.read(key, read)));
  CHECK(read == kText);
  CHECK(got(blobs->stored_bytes("ann")) == 3'500'000);
  CHECK(got(blobs->remove(key)));
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 0);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads") == 0);
  CHECK(got(blobs->stored_bytes("ann")) == 0);
  CHECK_FALSE(got(blobs.read(key, read)));
}

TEST_CASE("PostgreSQL blobs: the next put replaces a damaged one") {
  Blobs blobs;
  const BlobKey key = key_of("ann", kText);
  for (const char* damage : {"UPDATE blob_chunks SET bytes = set_byte(bytes, 5, 77) WHERE position = 2",
                             "DELETE FROM blob_chunks WHERE position = 3", "UPDATE blobs SET bytes = 3"}) {
    got(blobs->put(key, bytes_of(kText)));
    CHECK(got(blobs->put(key, bytes_of(kText))) == BlobPut::existed);
    blobs.execute(damage);
    CHECK(got(blobs->put(key, bytes_of(kText))) == BlobPut::created);
    std::string read;
    CHECK(got(blobs.read(key, read)));
    CHECK(read == kText);
    CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 4);
  }
  blobs.execute("DELETE FROM blob_chunks WHERE position = 1");
  std::string read;
  CHECK_FALSE(blobs.read(key, read).ok());
}

TEST_CASE("PostgreSQL blobs: chunks that the database loses are sent again") {
  for (const char* loss : {"blob_chunks WHERE position = 0 AND", "blob_uploads WHERE"}) {
    CAPTURE(loss);
    Blobs blobs;
    blobs.lose(loss, "nextval('inserts') = 3");
    const BlobKey key = key_of("ann", kText);
    CHECK(got(blobs->put(key, bytes_of(kText))) == BlobPut::created);
    std::string read;
    CHECK(got(blobs.read(key, read)));
    CHECK(read == kText);
    CHECK(got(blobs->stored_bytes("ann")) == 3'500'000);
    CHECK(got(blobs->put(key, bytes_of(kText))) == BlobPut::existed);
    got(blobs->remove_unused(std::vector{key}, 0s, none_reserved));
    CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 4);
    CHECK(blobs.number("SELECT count(*) FROM blob_uploads") == 0);
  }
}

TEST_CASE("PostgreSQL blobs: an upload that loses chunks each time is no blob") {
  Blobs blobs;
  blobs.lose("blob_chunks WHERE position = 1 AND", "true");
  const BlobKey key = key_of("ann", kText);
  const Result<BlobPut> put = blobs->put(key, bytes_of(kText));
  REQUIRE_FALSE(put.ok());
  CHECK(put.error().code == ErrorCode::storage_unavailable);
  CHECK_FALSE(got(blobs->exists(key)));
  CHECK(got(blobs->stored_bytes("ann")) == 0);
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 0);
}

TEST_CASE("PostgreSQL blobs: a missing chunk is damage, a removal during a read is not") {
  Blobs blobs;
  const BlobKey key = key_of("ann", kText);
  for (const auto& [change, code] :
       {std::pair("DELETE FROM blob_chunks WHERE position = 2", ErrorCode::internal),
        std::pair("DELETE FROM blobs; DELETE FROM blob_chunks", ErrorCode::storage_unavailable)}) {
    got(blobs->put(key, bytes_of(kText)));
    bool changed = false;
    const Result<bool> read = blobs->fetch(key, [&](std::span<const std::byte>) {
      if (!std::exchange(changed, true)) blobs.execute(change);
      return Result<Done>(Done{});
    });
    REQUIRE_FALSE(read.ok());
    CHECK(read.error().code == code);
  }
}

TEST_CASE("PostgreSQL blobs: a blob that became used after the listing is not removed") {
  PostgresForTests stores;
  const BlobKey used[] = {key_of("ann", "a"), key_of("ann", "b"), key_of("ann", "of a mesh")};
  const BlobKey unused = key_of("bob", "a");
  for (const char* text : {"a", "b", "of a mesh"}) got(stores.blobs().put(key_of("ann", text), bytes_of(text)));
  got(stores.blobs().put(unused, bytes_of("a")));
  NewJob job = new_job("ann", "j");
  job.mesh_a = used[0].id;
  job.mesh_b = used[1].id;
  got(stores.jobs().insert(job));
  got(stores.meshes().put_mesh({used[2], 9, "model/stl", "", at(0), at(0), at(1000)}, {1000}));
  CHECK(got(stores.blobs().remove_unused({}, 0s)) == 1);
  for (const BlobKey& key : used) CHECK(got(stores.blobs().exists(key)));
  CHECK_FALSE(got(stores.blobs().exists(unused)));
}

TEST_CASE("PostgreSQL blobs: a reserved blob is not removed by any process") {
  PostgresForTests stores;
  const auto others = stores.open("other");
  const BlobKey key = key_of("ann", "a");
  got(stores.blobs().put(key, bytes_of("a")));
  {
    const auto reserved = stores.blobs().reserve(key);
    CHECK(got(others->blobs().remove_unused({}, 0s)) == 0);
    CHECK(got(stores.blobs().remove_unused({}, 0s)) == 0);
    CHECK(got(stores.blobs().exists(key)));
  }
  CHECK(got(others->blobs().remove_unused({}, 0s)) == 1);
}

TEST_CASE("PostgreSQL blobs: an unfinished upload is no blob, and is removed when it is old") {
  Blobs blobs;
  blobs.execute(
      "INSERT INTO blob_uploads VALUES ('old', 1000), ('new', (extract(epoch FROM now()) * 1000)::int8), ('gone', 0); "
      "INSERT INTO blob_chunks SELECT upload, i, 'x' FROM unnest('{old,new,gone}'::bytea[]) AS upload, "
      "generate_series(0, 40) AS i");
  CHECK(got(blobs->remove_unused({}, 0s, none_reserved)) == 0);
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 41);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads WHERE upload = 'new'") == 1);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads") == 1);
}

TEST_CASE("PostgreSQL blobs: of concurrent puts of one blob one creates it") {
  Blobs blobs;
  const BlobKey key = key_of("ann", kText);
  std::vector<BlobPut> puts(4);
  std::vector<std::thread> threads;
  for (BlobPut& put : puts) {
    threads.emplace_back([&] { put = got(blobs->put(key, bytes_of(kText))); });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(std::count(puts.begin(), puts.end(), BlobPut::created) == 1);
  CHECK(got(blobs->stored_bytes("ann")) == 3'500'000);
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 4);
  CHECK(got(blobs->free_bytes()) == std::numeric_limits<std::uint64_t>::max());
}
