#include "server/store/postgres/pg_blobs.h"

#include <algorithm>
#include <limits>
#include <thread>

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
  // As far as there are bytes.
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

}  // namespace

TEST_CASE("PostgreSQL blobs: in chunks, all of which go with it") {
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

TEST_CASE("PostgreSQL blobs: a damaged one is replaced by the next that is put") {
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

TEST_CASE("PostgreSQL blobs: an upload that never ended is nothing, and is taken away when it is old") {
  Blobs blobs;
  blobs.execute(
      "INSERT INTO blob_uploads VALUES ('old', 1000), ('new', (extract(epoch FROM now()) * 1000)::int8), ('gone', 0); "
      "INSERT INTO blob_chunks SELECT upload, i, 'x' FROM unnest('{old,new,gone}'::bytea[]) AS upload, "
      "generate_series(0, 40) AS i");
  CHECK(got(blobs->remove_unused({}, 0s, {})) == 0);
  CHECK(blobs.number("SELECT count(*) FROM blob_chunks") == 41);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads WHERE upload = 'new'") == 1);
  CHECK(blobs.number("SELECT count(*) FROM blob_uploads") == 1);
}

TEST_CASE("PostgreSQL blobs: of several that put the same at once, one makes it") {
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
