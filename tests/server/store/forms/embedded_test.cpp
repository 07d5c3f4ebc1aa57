#include "server/store/forms/stores.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "server/store/sqlite.h"
#include "tests/server/store/batch_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
namespace fs = std::filesystem;

namespace {

fs::perms permissions_of(const fs::path& path) { return fs::status(path).permissions(); }

void write(const std::string& path, const std::string& content) { std::ofstream(path, std::ios::binary) << content; }

std::string path_of(const EmbeddedForTests& stores, const BlobKey& key) {
  const std::string owner = api::sha256_hex(bytes_of(key.owner));
  return stores.folder() / ("data/blobs/" + owner + "/" + key.id.substr(0, 2) + "/" + key.id);
}

std::string refusal_of(const std::string& folder) {
  const Result<std::unique_ptr<AllStores>> stores = AllStores::open_embedded({folder});
  REQUIRE_FALSE(stores.ok());
  return stores.error().message;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("embedded: files are private to their user") {
  const TestFolder folder;
  const std::string data = folder / "new/data/";  // created with its parents
  const mode_t before = ::umask(0);
  {
    const auto stores = got(AllStores::open_embedded({data}));
    got(stores->jobs().insert(new_job("ann", "1")));
    got(stores->blobs().put(key_of("ann", "x"), bytes_of("x")));
    int files = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(data)) {
      CAPTURE(entry.path());
      CHECK(permissions_of(entry) == (entry.is_directory() ? fs::perms(0700) : fs::perms(0600)));
      files += entry.is_directory() ? 0 : 1;
    }
    CHECK(files == 6);  // lock, database, its log and index, a blob
    CHECK(permissions_of(data) == fs::perms(0700));
  }
  ::umask(before);
}

TEST_CASE("embedded: no name of an owner is in a path") {
  EmbeddedForTests stores;
  got(stores.blobs().put(key_of("../ann", "x"), bytes_of("x")));
  CHECK(fs::exists(path_of(stores, key_of("../ann", "x"))));
}

TEST_CASE("embedded: a folder belongs to one process until its end") {
  const TestFolder folder;
  auto stores = got(AllStores::open_embedded({folder / "data"}));
  const std::string refusal = refusal_of(folder / "data");
  CHECK(contains(refusal,
                 "'" + folder.path() + "/data' is used by another process (" + std::to_string(::getpid()) + ")"));
  stores.reset();
  // A killed process leaves the folder free.
  const pid_t child = ::fork();
  if (child == 0) {
    const auto held = AllStores::open_embedded({folder / "data"});
    ::_exit(held.ok() ? 0 : 1);
  }
  int status = 0;
  CHECK(::waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  CHECK(AllStores::open_embedded({folder / "data"}).ok());
}

TEST_CASE("embedded: a folder that is no folder, or cannot be created, is an error") {
  const TestFolder folder;
  write(folder / "file", "x");
  CHECK(contains(refusal_of(folder / "file"), "Not a directory"));
  CHECK(contains(refusal_of(folder / "file/data"), "cannot be made"));
  CHECK(contains(refusal_of("/proc/meshgauge/data"), "cannot be made"));
}

TEST_CASE("embedded: leftovers of a crash are removed, blobs are not") {
  EmbeddedForTests stores;
  const BlobKey key = key_of("ann", "x");
  got(stores.blobs().put(key, bytes_of("x")));
  write(stores.folder() / "data/blobs/incoming/half", "xxx");
  stores.reopen();
  CHECK_FALSE(fs::exists(stores.folder() / "data/blobs/incoming/half"));
  CHECK(got(stores.blobs().exists(key)));
}

TEST_CASE("embedded: a truncated or damaged blob is replaced by the next put") {
  EmbeddedForTests stores;
  const std::string text = std::string(3'000'000, 'x') + "content";
  const BlobKey key = key_of("ann", text);
  const std::string path = path_of(stores, key);
  got(stores.blobs().put(key, bytes_of(text)));
  fs::resize_file(path, 3);
  CHECK(got(stores.blobs().put(key, bytes_of(text))) == BlobPut::created);
  CHECK(text_of(*got(stores.blobs().open(key))) == text);
  std::fstream(path, std::ios::binary | std::ios::in | std::ios::out).seekp(2'999'999) << "y";
  CHECK(text_of(*got(stores.blobs().open(key))) != text);
  CHECK(got(stores.blobs().put(key, bytes_of(text + "z"))) == BlobPut::other_digest);
  CHECK(got(stores.blobs().put(key, bytes_of(text))) == BlobPut::created);
  CHECK(text_of(*got(stores.blobs().open(key))) == text);
  CHECK(got(stores.blobs().put(key, bytes_of(text))) == BlobPut::existed);
}

TEST_CASE("embedded: a blob that is put during its removal by age exists afterwards") {
  EmbeddedForTests stores;
  const std::string text(200'000, 'x');
  const BlobKey key = key_of("ann", text);
  const std::string path = path_of(stores, key);
  int removed = 0;
  for (int i = 0; i < 100; ++i) {
    got(stores.blobs().put(key, bytes_of(text)));
    fs::last_write_time(path, fs::file_time_type::clock::now() - std::chrono::hours(2));
    std::thread sweeper([&] {
      const Result<std::uint64_t> swept = stores.blobs().remove_unused({}, std::chrono::hours(1));
      removed += swept ? static_cast<int>(*swept) : 0;
    });
    if (i % 3 != 0) std::this_thread::sleep_for(std::chrono::microseconds(10 * i));
    const Result<BlobPut> put = stores.blobs().put(key, bytes_of(text));
    sweeper.join();
    CHECK(put.ok());
    CHECK(got(stores.blobs().exists(key)));
  }
  MESSAGE("removed before it was put again: " << removed << " of 100");
}

TEST_CASE("embedded: a damaged database is refused by name") {
  const TestFolder folder;
  const std::string database = folder / "data/jobs.sqlite";
  fs::create_directory(folder / "data");
  SUBCASE("no database at all") {
    write(database, std::string(8192, 'x'));
    CHECK(contains(refusal_of(folder / "data"), "'" + database + "' is damaged"));
  }
  SUBCASE("a page overwritten") {
    {
      const auto stores = got(AllStores::open_embedded({folder / "data"}));
      for (int i = 0; i < 200; ++i) stores->jobs().record(ended_job("ann", std::to_string(i)));
    }
    std::fstream file(database, std::ios::in | std::ios::out | std::ios::binary);
    for (int page = 3; page < 20; ++page) {
      file.seekp(page * 4096);
      file << std::string(512, '\x7f');
    }
    file.close();
    CHECK(contains(refusal_of(folder / "data"), "'" + database + "' is damaged"));
  }
  SUBCASE("cut short") {
    {
      const auto stores = got(AllStores::open_embedded({folder / "data"}));
      for (int i = 0; i < 200; ++i) stores->jobs().record(ended_job("ann", std::to_string(i)));
    }
    fs::resize_file(database, fs::file_size(database) / 2);
    CHECK(contains(refusal_of(folder / "data"), "'" + database + "' is damaged"));
  }
}

namespace {

// Neither takes a job nor says that it does, and names no path.
void check_takes_nothing(EmbeddedForTests& stores, ErrorCode code) {
  const Result<Inserted> inserted = stores.jobs().insert(new_job("ann", "lost"));
  const Result<Done> checked = stores.jobs().check();
  REQUIRE_FALSE(inserted.ok());
  REQUIRE_FALSE(checked.ok());
  for (const Error& error : {inserted.error(), checked.error()}) {
    CAPTURE(error.message);
    CHECK(error.code == code);
    CHECK_FALSE(contains(error.message, stores.folder().path()));
  }
}

}  // namespace

TEST_CASE("embedded: a database whose files are moved away or replaced takes nothing until they are back") {
  EmbeddedForTests stores;
  got(stores.jobs().insert(new_job("ann", "1")));
  got(stores.jobs().check());
  for (const char* const name : {"jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm"}) {
    CAPTURE(name);
    const std::string path = stores.folder() / (std::string("data/") + name), away = stores.folder() / "away";
    fs::rename(path, away);
    check_takes_nothing(stores, ErrorCode::storage_unavailable);
    fs::copy_file(away, path);
    check_takes_nothing(stores, ErrorCode::storage_unavailable);
    fs::rename(away, path);
    got(stores.jobs().check());
    got(stores.jobs().insert(new_job("ann", name)));
  }
  stores.reopen();
  for (const char* const id : {"1", "jobs.sqlite", "jobs.sqlite-wal", "jobs.sqlite-shm"}) {
    CHECK(got(stores.jobs().get({"ann", id})).has_value());
  }
  CHECK_FALSE(got(stores.jobs().get({"ann", "lost"})).has_value());
}

TEST_CASE("embedded: a database that is overwritten while it is open takes nothing, though its pages are in memory") {
  EmbeddedForTests stores;
  got(stores.jobs().insert(new_job("ann", "1")));
  const std::string path = stores.folder() / "data/jobs.sqlite";
  SUBCASE("its file") { std::fstream(path, std::ios::in | std::ios::out | std::ios::binary) << std::string(8192, 'x'); }
  SUBCASE("its log") {
    std::fstream(path + "-wal", std::ios::in | std::ios::out | std::ios::binary) << std::string(8192, 'x');
  }
  SUBCASE("its file is empty") { fs::resize_file(path, 0); }
  check_takes_nothing(stores, ErrorCode::storage_damaged);
}

TEST_CASE("embedded: a check tries a job that has ended, not each time, and again after one that could not be stored") {
  EmbeddedForTests stores;
  Connection raw(stores.folder() / "data/jobs.sqlite", Connection::Use::write);
  const auto number = [&](const char* sql) {
    Query row(raw, sql);
    REQUIRE(row.next());
    return row.number(0);
  };
  raw.execute("CREATE TABLE tried (state INTEGER)");
  raw.execute("CREATE TRIGGER note AFTER INSERT ON jobs BEGIN INSERT INTO tried VALUES (new.state); END");
  constexpr int kChecks = 10;
  for (int i = 0; i < kChecks; ++i) got(stores.jobs().check());
  CHECK(number("SELECT count(*) FROM tried") >= 1);
  CHECK(number("SELECT count(*) FROM tried") < kChecks);
  CHECK(number("SELECT count(*) FROM tried WHERE state < 2") == 0);
  raw.execute("CREATE TRIGGER refuse BEFORE INSERT ON jobs BEGIN SELECT RAISE(ABORT, 'refused'); END");
  CHECK_FALSE(stores.jobs().insert(new_job("ann", "1")).ok());
  CHECK_FALSE(stores.jobs().check().ok());
  raw.execute("DROP TRIGGER refuse");
  got(stores.jobs().check());
}

TEST_CASE("embedded: blobs are stored again after their folders were removed") {
  EmbeddedForTests stores;
  got(stores.blobs().put(key_of("ann", "x"), bytes_of("x")));
  got(stores.blobs().check());
  const std::string root = stores.folder() / "data/blobs";
  fs::remove_all(fs::path(path_of(stores, key_of("ann", "x"))).parent_path().parent_path());
  CHECK(got(stores.blobs().put(key_of("ann", "x"), bytes_of("x"))) == BlobPut::created);
  CHECK(text_of(*got(stores.blobs().open(key_of("ann", "x")))) == "x");
  fs::rename(root, root + "-away");
  CHECK_FALSE(stores.blobs().check().ok());
  fs::rename(root + "-away", root);
  got(stores.blobs().check());
  CHECK(fs::is_empty(root + "/incoming"));
}

TEST_CASE("write behind: while nothing can be written the newest records are held") {
  std::optional<ErrorCode> trouble = ErrorCode::storage_full;  // no record is given while it changes
  std::vector<std::string> written;
  std::size_t touched = 0;
  WriteBehind behind(3, [&](const WriteBehind::Batch& batch) -> Result<Done> {
    if (trouble) return Error{*trouble, "says the test", "", ""};
    for (const auto& job : batch.jobs) written.push_back(job->key.id);
    touched += batch.touches.size();
    return Done{};
  });
  const auto counts = [&] {
    Counts counted;
    behind.add_to(counted);
    return counted;
  };
  for (int i = 0; i < 5; ++i) behind.record(ended_job("ann", std::to_string(i)));
  behind.touch({"ann", "m"}, {at(1), at(2)});
  CHECK_FALSE(behind.flush().ok());
  CHECK(counts().unrecorded == 3);
  CHECK(counts().dropped_records == 2);
  CHECK(behind.find({"ann", "1"}) == nullptr);
  CHECK(behind.find({"ann", "2"}) != nullptr);
  behind.record(ended_job("ann", "5"));
  CHECK_FALSE(behind.flush().ok());
  CHECK(counts().dropped_records == 3);
  CHECK(behind.find({"ann", "2"}) == nullptr);
  trouble.reset();
  got(behind.flush());
  CHECK(written == std::vector<std::string>{"3", "4", "5"});
  CHECK(touched == 1);
  CHECK(counts().unrecorded == 0);
  CHECK(behind.find({"ann", "3"}) == nullptr);
  trouble = ErrorCode::internal;  // does not pass
  behind.record(ended_job("ann", "6"));
  CHECK_FALSE(behind.flush().ok());
  CHECK(counts().dropped_records == 4);
  CHECK(counts().unrecorded == 0);
}

TEST_CASE("embedded: a start finishes cancelling a batch") {
  EmbeddedForTests stores;
  NewBatch batch = new_batch("ann", "b", 600);
  batch.items[1].work = batch.items[0].work;
  insert(stores.batches(), batch);
  const Token runs = claimed_token(stores.jobs(), {"ann", "b/2"});
  {
    Connection other(stores.folder() / "data/jobs.sqlite", Connection::Use::write);
    Query(other, "UPDATE batches SET cancel_requested = 1").run();
  }
  SUBCASE("restarted") {
    stores.reopen();
    got(stores.jobs().recover("w1", "the service ended", kNow));
    CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.cancelled == 600);
  }
  SUBCASE("swept") {
    got(stores.jobs().sweep_jobs(kNow, 1000));
    CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.cancelled == 599);
    CHECK(got(heartbeat(stores.jobs(), runs, at(170), {})) == Heartbeat::cancel);
  }
}
