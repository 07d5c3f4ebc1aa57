// Full and read-only disks: real ones of a few megabytes, in a private mount namespace where the test may create one;
// and a limit on the size of files, which works everywhere.
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <fstream>

#include "implementations.h"
#include "server/store/file_blobs.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
namespace fs = std::filesystem;

namespace {

// 4 MB in memory, for this process alone.
class SmallDisk {
 public:
  SmallDisk() {
    mounted_ = ::unshare(CLONE_NEWNS) == 0 && ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
               ::mount("none", path().c_str(), "tmpfs", 0, "size=8m") == 0;
    if (!mounted_) WARN_MESSAGE(false, "SKIPPED: this process may not mount a small disk");
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(path().c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  explicit operator bool() const { return mounted_; }
  std::string path() const { return folder_.path(); }
  // A file that takes all but `left` bytes; the destructor removes it.
  void fill(std::uintmax_t left) const {
    const std::string block(4096, 'x');
    std::ofstream file(ballast(), std::ios::binary);
    while (fs::space(path()).available > left && file.write(block.data(), 4096).flush()) {
    }
  }
  void make_room() const { fs::remove(ballast()); }
  bool make_read_only(bool read_only) const {
    const unsigned long flags = read_only ? MS_REMOUNT | MS_RDONLY : MS_REMOUNT;
    return ::mount(nullptr, path().c_str(), nullptr, flags, nullptr) == 0;
  }

 private:
  std::string ballast() const { return folder_ / "ballast"; }

  TestFolder folder_;
  bool mounted_ = false;
};

// Like a full disk, for files that grow beyond the limit.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t most) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{most, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallFiles() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    ::signal(SIGXFSZ, SIG_DFL);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;

 private:
  rlimit before_{};
};

NewJob large_job(const std::string& id) {
  NewJob job = new_job("ann", id);
  job.options = std::string(100'000, 'o');
  return job;
}

// Inserts until it fails; returns the number of stored jobs.
int insert_until_full(JobStore& jobs, const std::string& prefix) {
  for (int i = 0; i < 1000; ++i) {
    const Result<Inserted> inserted = jobs.insert(large_job(prefix + std::to_string(i)));
    if (inserted) continue;
    CHECK_MESSAGE(inserted.error().code == ErrorCode::storage_full, inserted.error().message);
    return i;
  }
  FAIL("the disk is never full");
  return 0;
}

void check_full(AllStores& stores, const std::string& blobs_folder) {
  JobStore& jobs = stores.jobs();
  const BlobKey small = key_of("ann", "small");
  got(stores.blobs().put(small, bytes_of("small")));
  const int stored = insert_until_full(jobs, "");
  CHECK(stored > 0);
  CHECK_FALSE(got(jobs.get({"ann", std::to_string(stored)})).has_value());
  for (int i = 0; i < stored; ++i) CHECK(got(jobs.get({"ann", std::to_string(i)})).has_value());

  const std::string large(8'000'000, 'x');
  const Result<BlobPut> put = stores.blobs().put(key_of("ann", large), bytes_of(large));
  REQUIRE_FALSE(put.ok());
  CHECK(put.error().code == ErrorCode::storage_full);
  CHECK_FALSE(got(stores.blobs().exists(key_of("ann", large))));
  CHECK(fs::is_empty(blobs_folder + "/incoming"));
  CHECK(text_of(*got(stores.blobs().open(small))) == "small");

  Job unrecorded = ended_job("ann", "unrecorded");
  unrecorded.document = std::string(3'000'000, 'd');
  jobs.record(unrecorded);
  const Result<Done> flushed = jobs.flush();
  REQUIRE_FALSE(flushed.ok());
  CHECK(flushed.error().code == ErrorCode::storage_full);
  CHECK(got(jobs.get(unrecorded.key)).has_value());
  CHECK(got(jobs.counts()).unrecorded == 1);
}

void check_recovered(AllStores& stores) {
  got(stores.jobs().check());
  got(stores.blobs().check());
  got(stores.jobs().flush());
  CHECK(got(stores.jobs().counts()).unrecorded == 0);
  CHECK_FALSE(got(stores.jobs().insert(large_job("afterwards"))).existed);
  const std::string text(100'000, 'x');
  CHECK(got(stores.blobs().put(key_of("ann", text), bytes_of(text))) == BlobPut::created);
}

}  // namespace

TEST_CASE("trouble: a full disk is an error, nothing is stored by half, and room ends it") {
  const SmallDisk disk;
  if (!disk) return;
  {
    const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
    disk.fill(700'000);
    check_full(*stores, disk.path() + "/data/blobs");
    disk.fill(0);
    const Result<Done> blobs = stores->blobs().check();
    REQUIRE_FALSE(blobs.ok());
    CHECK(blobs.error().code == ErrorCode::storage_full);
    insert_until_full(stores->jobs(), "more ");  // the log may have had room left for some
    disk.make_room();
    check_recovered(*stores);
  }
  const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
  CHECK(got(stores->jobs().get({"ann", "unrecorded"}))->document.size() == 3'000'000);
  CHECK(got(stores->jobs().get({"ann", "afterwards"})).has_value());
}

TEST_CASE("trouble: rows are removed from a full disk, though all room is taken again after each removal") {
  const SmallDisk disk;
  if (!disk) return;
  const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
  JobStore& jobs = stores->jobs();
  constexpr int kJobs = 300;
  for (int i = 0; i < kJobs; ++i) {
    Job job = ended_job("ann", std::to_string(i));
    job.document = std::string(3000, 'd');
    jobs.record(job);
  }
  got(jobs.flush());
  got(stores->meshes().put_mesh({key_of("ann", "m"), 1, "", "", at(0), at(0), at(50)}, {100}));
  disk.fill(0);
  for (int i = 0; i < 100; ++i) {
    REQUIRE(got(jobs.forget({"ann", std::to_string(i)})));
    disk.fill(0);
  }
  CHECK(got(stores->meshes().sweep_meshes(at(50))).size() == 1);
  disk.fill(0);
  CHECK(got(jobs.sweep_jobs({at(2000), at(3000)}, 1000)).expired == kJobs - 100);
  disk.fill(0);
  insert_until_full(jobs, "more ");  // the log may have room for some
  disk.make_room();
  got(jobs.insert(large_job("afterwards")));
}

TEST_CASE("trouble: a record that a full disk does not take can be forgotten") {
  const SmallDisk disk;
  if (!disk) return;
  const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
  disk.fill(0);
  const Job job = ended_job("ann", "1");
  stores->jobs().record(job);
  CHECK_FALSE(stores->jobs().flush().ok());
  CHECK(got(stores->jobs().forget(job.key)));
  CHECK_FALSE(got(stores->jobs().get(job.key)).has_value());
  disk.make_room();
  got(stores->jobs().flush());
  CHECK_FALSE(got(stores->jobs().get(job.key)).has_value());
}

TEST_CASE("trouble: a restart on a full disk works, and what fills it can be removed") {
  const SmallDisk disk;
  if (!disk) return;
  {
    const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
    got(stores->jobs().insert(new_job("ann", "1")));
    stores->jobs().record(ended_job("ann", "2"));
  }
  disk.fill(0);
  {
    const auto stores = got(AllStores::open_embedded({disk.path() + "/data"}));
    disk.fill(0);
    CHECK(got(stores->jobs().forget({"ann", "2"})));
  }
  disk.make_room();
  CHECK(got(got(AllStores::open_embedded({disk.path() + "/data"}))->jobs().get({"ann", "1"})).has_value());
}

TEST_CASE("trouble: the limit on file size is like a full disk") {
  EmbeddedForTests for_tests;
  const std::string data = for_tests.folder() / "data2";
  const auto stores = got(AllStores::open_embedded({data}));
  {
    const SmallFiles limit(1'000'000);
    check_full(*stores, data + "/blobs");
  }
  check_recovered(*stores);
}

TEST_CASE("trouble: a read-only disk is an error for writes, and can be read") {
  const SmallDisk disk;
  if (!disk) return;
  const std::unique_ptr<FileBlobs> blobs = got(FileBlobs::open(disk.path() + "/blobs"));
  const BlobKey key = key_of("ann", "x");
  got(blobs->put(key, bytes_of("x")));
  got(got(AllStores::open_embedded({disk.path() + "/data"}))->jobs().insert(new_job("ann", "1")));
  REQUIRE(disk.make_read_only(true));
  for (const Result<BlobPut>& put : {blobs->put(key_of("ann", "y"), bytes_of("y")), blobs->put(key, bytes_of("x"))}) {
    REQUIRE_FALSE(put.ok());
    CHECK(put.error().code == ErrorCode::storage_unavailable);
    CHECK(put.error().message.find("Read-only file system") != std::string::npos);
  }
  CHECK_FALSE(blobs->renew(key).ok());
  CHECK_FALSE(blobs->remove(key).ok());
  CHECK_FALSE(blobs->remove_unused({}, std::chrono::seconds(0)).ok());
  CHECK_FALSE(blobs->check().ok());
  CHECK(text_of(*got(blobs->open(key))) == "x");
  for (const char* name : {"/data", "/new"}) {
    const Result<std::unique_ptr<AllStores>> stores = AllStores::open_embedded({disk.path() + name});
    REQUIRE_FALSE(stores.ok());
    CHECK(stores.error().code == ErrorCode::storage_unavailable);
    CHECK(stores.error().message.find("Read-only file system") != std::string::npos);
  }
  REQUIRE(disk.make_read_only(false));
  CHECK(got(blobs->put(key_of("ann", "y"), bytes_of("y"))) == BlobPut::created);
  CHECK(got(got(AllStores::open_embedded({disk.path() + "/data"}))->jobs().get({"ann", "1"})).has_value());
}
