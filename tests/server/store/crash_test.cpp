// A process that writes to the stores in a loop is killed at random moments. Everything that it had acknowledged must
// be there, complete, when the folder is opened again. MESHGAUGE_CRASHES: how many times (15 by default).
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "implementations.h"
#include "single_job.h"

using namespace meshgauge;
using namespace meshgauge::server::store;
namespace fs = std::filesystem;

namespace {

int crashes() {
  const char* text = std::getenv("MESHGAUGE_CRASHES");
  return text != nullptr ? std::atoi(text) : 15;
}

// A content of any size up to 300 kB, determined by its number.
std::string content(const std::string& name) {
  const std::size_t number = std::hash<std::string>()(name);
  std::string text = name + " ";
  text.resize(name.size() + 1 + number % (number % 7 == 0 ? 300'000 : 3'000), static_cast<char>('a' + number % 26));
  return text;
}

// The process that will be killed: each line it writes is a promise.
class Victim {
 public:
  Victim(const std::string& folder, int round, int promises)
      : prefix_(std::to_string(round) + "-"), promises_(promises), stores_(AllStores::open_embedded({folder})) {}

  void run() {
    if (!stores_) return promise("failed", stores_.error().message);
    std::vector<std::thread> threads;
    threads.emplace_back([this] { insert(); });
    threads.emplace_back([this] { finish(); });
    threads.emplace_back([this] { put(); });
    threads.emplace_back([this] { record(); });
    for (std::thread& thread : threads) thread.join();
  }

 private:
  JobStore& jobs() { return (*stores_)->jobs(); }

  // One write() each, shorter than PIPE_BUF, so atomic.
  void promise(const std::string& what, const std::string& name) const {
    const std::string line = what + " " + name + "\n";
    if (::write(promises_, line.data(), line.size()) < 0) ::_exit(1);
  }

  template <class T>
  void stop_unless(const Result<T>& result) const {
    if (result) return;
    promise("failed", result.error().message);
    ::_exit(1);
  }

  void insert() {
    for (int i = 0;; ++i) {
      NewJob job = new_job("ann", "i" + prefix_ + std::to_string(i));
      job.options = content(job.key.id);
      job.idempotency_key = "key of " + job.key.id;
      stop_unless(jobs().insert(job));
      promise("inserted", job.key.id);
    }
  }

  void finish() {
    for (int i = 0;; ++i) {
      NewJob job = new_job("bob", "f" + prefix_ + std::to_string(i));
      job.created = at(-1'000'000L * (1 + std::stoi(prefix_)) - i);  // claimed before all others
      stop_unless(jobs().insert(job));
      const Result<std::vector<Claimed>> claimed = jobs().claim_some("victim", at(1), at(60), 1);
      stop_unless(claimed);
      promise("claimed", job.key.id);
      const Ending ending{JobState::done, content(job.key.id), "", at(2), at(100)};
      stop_unless(meshgauge::server::store::finish(jobs(), claimed->front().token, ending));
      promise("finished", job.key.id);
    }
  }

  void put() {
    for (int i = 0;; ++i) {
      const std::string name = "b" + prefix_ + std::to_string(i);
      const BlobKey key = key_of("ann", content(name));
      stop_unless((*stores_)->blobs().put(key, bytes_of(content(name))));
      promise("put", name);
      if (i % 3 != 0) continue;
      promise("removes", name);
      stop_unless((*stores_)->blobs().remove(key));
    }
  }

  void record() {
    for (int i = 0;; ++i) {
      Job job = ended_job("cid", "r" + prefix_ + std::to_string(i));
      job.document = content(job.key.id);
      jobs().record(job);
      stop_unless(jobs().flush());
      promise("recorded", job.key.id);
    }
  }

  const std::string prefix_;
  const int promises_;
  Result<std::unique_ptr<AllStores>> stores_;
};

using Promises = std::vector<std::pair<std::string, std::string>>;

// Starts a process, kills it, and returns its promises.
Promises kill_one(const std::string& folder, int round, std::chrono::milliseconds after) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    Victim(folder, round, ends[1]).run();
    ::_exit(1);
  }
  ::close(ends[1]);
  std::string text;
  std::thread reader([&] {
    char piece[4096];
    ssize_t n = 0;
    while ((n = ::read(ends[0], piece, sizeof piece)) > 0) text.append(piece, static_cast<std::size_t>(n));
  });
  std::this_thread::sleep_for(after);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  reader.join();
  ::close(ends[0]);
  Promises promises;
  std::istringstream lines(text);
  for (std::string what, name; lines >> what && std::getline(lines >> std::ws, name);)
    promises.emplace_back(what, name);
  return promises;
}

void check_job(JobStore& jobs, const std::string& what, const JobKey& key, bool was_finished) {
  const std::optional<Job> job = got(jobs.get(key));
  REQUIRE_MESSAGE(job.has_value(), what);
  if (what == "inserted") {
    CHECK(job->state == JobState::queued);
    CHECK(job->options == content(key.id));
    CHECK(got(jobs.find_idempotent(key.owner, "key of " + key.id))->key == key);
  } else if (what == "claimed" && !was_finished) {
    CHECK(job->tries == 1);
    // The process was killed before the end was promised.
    CHECK((job->state == JobState::queued || job->document == content(key.id)));
  } else {
    CHECK(job->state == JobState::done);
    CHECK(job->document == content(key.id));
  }
}

void check_promises(AllStores& stores, const Promises& promises) {
  const std::set<std::pair<std::string, std::string>> all(promises.begin(), promises.end());
  for (const auto& [what, name] : promises) {
    CAPTURE(what);
    CAPTURE(name);
    CHECK_MESSAGE(what != "failed", name);
    if (what == "put") {
      const std::optional<Blob> blob = got(stores.blobs().open(key_of("ann", content(name))));
      if (all.contains({"removes", name})) continue;
      REQUIRE(blob.has_value());
      CHECK(text_of(*blob) == content(name));
    } else if (what != "removes") {
      const std::string owner = what == "inserted" ? "ann" : what == "recorded" ? "cid" : "bob";
      check_job(stores.jobs(), what, {owner, name}, all.contains({"finished", name}));
    }
  }
}

void check_whole_blobs(const std::string& blobs) {
  CHECK(fs::is_empty(blobs + "/incoming"));
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(blobs)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    CHECK(api::sha256_hex(bytes_of(text)) == entry.path().filename().string());
  }
}

}  // namespace

TEST_CASE("crash: acknowledged data is there, complete") {
  const TestFolder folder;
  const std::string data = folder / "data";
  std::mt19937 dice(20240607);
  std::size_t promised = 0;
  Promises earlier;
  for (int round = 0; round < crashes(); ++round) {
    CAPTURE(round);
    // Each crash checks everything that has gathered: start again before that is too much.
    if (round % 3 == 0) {
      earlier.clear();
      std::filesystem::remove_all(data);
    }
    const auto after = std::chrono::milliseconds(std::uniform_int_distribution<int>(5, 150)(dice));
    const Promises promises = kill_one(data, round, after);
    promised += promises.size();
    const auto stores = got(AllStores::open_embedded({data}));
    got(stores->jobs().recover("victim", "it was killed", {at(3), at(100)}));
    check_promises(*stores, promises);
    check_promises(*stores, earlier);
    check_whole_blobs(data + "/blobs");
    CHECK(got(stores->jobs().counts()).running == 0);
    earlier = promises;
  }
  MESSAGE("promises kept: " << promised);
  CHECK(promised > 0);
}
