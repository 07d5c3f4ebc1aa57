// Claims, heartbeats and ends of many jobs at once.
#include <map>
#include <random>
#include <set>

#include "batch_steps.h"
#include "server/store/policy.h"

using namespace meshgauge::server::store;

using Ids = std::vector<std::string>;

TEST_CASE_TEMPLATE("claims: several of one batch at once, the smallest first", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch batch = new_batch("ann", "b", 5);
  for (std::size_t i = 0; i < 5; ++i) batch.items[i].job.cost = 5000 - 1000 * i;
  insert(stores.batches(), batch);
  CHECK(claim_ids(stores.jobs(), 3) == Ids{"b/4", "b/3", "b/2"});
  CHECK(claim_ids(stores.jobs(), 3) == Ids{"b/1", "b/0"});
  CHECK(claim_ids(stores.jobs(), 3).empty());
  const Job job = job_in(stores.jobs(), {"ann", "b/4"});
  CHECK(job.state == JobState::running);
  CHECK(job.tries == 1);
  CHECK(job.started == at(50));
}

TEST_CASE_TEMPLATE("claims: together no larger than kBytesOfOneSecond", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch batch = new_batch("ann", "b", 4);
  for (BatchItem& item : batch.items) item.job.cost = 20'000'000;
  batch.items[3].job.cost = 900'000'000;
  insert(stores.batches(), batch);
  CHECK(claim_ids(stores.jobs(), 10) == Ids{"b/0", "b/1"});
  CHECK(claim_ids(stores.jobs(), 10) == Ids{"b/2"});
  CHECK(claim_ids(stores.jobs(), 10) == Ids{"b/3"});  // however large it is
}

TEST_CASE_TEMPLATE("claims: owners share, then the batches and the single jobs of each", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewBatch first = new_batch("ann", "b", 20);
  NewBatch second = new_batch("ann", "c", 20);
  for (BatchItem& item : second.items) item.job.created = at(1);
  insert(stores.batches(), first);
  insert(stores.batches(), second);
  NewJob single = new_job("ann", "single");
  single.created = at(2);
  insert(stores.jobs(), single);
  NewJob other = new_job("bob", "other");
  other.created = at(3);
  insert(stores.jobs(), other);
  CHECK(claim_ids(stores.jobs(), 2) == Ids{"b/0", "b/1"});
  CHECK(claim_ids(stores.jobs(), 2) == Ids{"other"});  // its owner has none running
  CHECK(claim_ids(stores.jobs(), 2) == Ids{"c/0", "c/1"});
  CHECK(claim_ids(stores.jobs(), 2) == Ids{"single"});
  CHECK(claim_ids(stores.jobs(), 1) == Ids{"b/2"});
  CHECK(claim_ids(stores.jobs(), 1) == Ids{"c/2"});
}

TEST_CASE_TEMPLATE("claims: clients of one owner share", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  const auto queue = [&](const char* client, const char* id, int created) {
    NewJob job = new_job("", id);
    job.client = client;
    job.created = at(created);
    insert(stores.jobs(), job);
  };
  NewBatch batch = new_batch("", "b", 5);
  for (BatchItem& item : batch.items) item.job.client = "greedy";
  insert(stores.batches(), batch);
  for (const char* id : {"1", "2", "3"}) queue("greedy", id, 1);
  queue("modest", "4", 9);
  queue("modest", "5", 9);
  CHECK(claim_ids(stores.jobs(), 1) == Ids{"b/0"});
  CHECK(got(stores.jobs().claim_some("w", at(50), at(110), 1, JobStore::Suspects::too,
                                     JobStore::Clients::with_none_running))
            .at(0)
            .job.client == "modest");
  CHECK(claim_ids(stores.jobs(), 1) == Ids{"1"});
  CHECK(claim_ids(stores.jobs(), 1) == Ids{"5"});  // its client has fewer running
}

TEST_CASE_TEMPLATE("claims: a job that is suspected comes alone", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 4));
  CHECK_FALSE(job_in(jobs, {"ann", "b/1"}).suspected);
  const std::optional<Claimed> first = claim_one(jobs, {"ann", "b/1"}, "w1", at(50), at(110));
  CHECK_FALSE(first->job.suspected);
  CHECK(got(jobs.hand_back(first->token, "", kNow)) == JobState::queued);  // excused
  CHECK_FALSE(job_in(jobs, {"ann", "b/1"}).suspected);
  CHECK(got(jobs.hand_back(claimed_token(jobs, {"ann", "b/1"}), "its worker was lost", kNow)) == JobState::queued);
  CHECK(job_in(jobs, {"ann", "b/1"}).suspected);

  CHECK(claim_ids(jobs, 10) == Ids{"b/0"});  // up to it
  const std::vector<Claimed> alone = got(jobs.claim_some("w1", at(50), at(110), 10));
  REQUIRE(alone.size() == 1);
  CHECK(alone[0].token.key.id == "b/1");
  CHECK(alone[0].job.suspected);
  CHECK(job_in(jobs, {"ann", "b/1"}).suspected);
  CHECK(claim_ids(jobs, 10) == Ids{"b/2", "b/3"});
}

TEST_CASE_TEMPLATE("claims: suspected jobs are passed over, also all of a batch", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 4));
  insert(stores.batches(), new_batch("ann", "c", 1));
  insert(jobs, new_job("ann", "single"));
  NewJob last = new_job("zoe", "last");
  last.created = at(1);
  insert(jobs, last);
  for (const std::string id : {"b/0", "b/2", "c/0", "single"}) {
    CHECK(got(jobs.hand_back(claimed_token(jobs, {"ann", id}), "its worker was lost", kNow)) == JobState::queued);
  }
  const auto claimed = [&](JobStore::Suspects suspects) { return claim_ids(jobs, 10, suspects); };
  CHECK(claimed(JobStore::Suspects::passed_over) == Ids{"b/1", "b/3"});
  CHECK(claimed(JobStore::Suspects::passed_over) == Ids{"last"});
  CHECK(claimed(JobStore::Suspects::passed_over).empty());
  std::set<std::string> suspected;
  for (int i = 0; i < 4; ++i) {
    const Ids one = claimed(JobStore::Suspects::too);
    REQUIRE(one.size() == 1);
    suspected.insert(one[0]);
  }
  CHECK(suspected == std::set<std::string>{"b/0", "b/2", "c/0", "single"});
}

TEST_CASE_TEMPLATE("claims: of jobs lost with their worker, those that may have begun are suspected", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 3));
  NewJob single = new_job("zoe", "single");
  single.created = at(1);
  insert(jobs, single);
  const auto lose = [&] { got(jobs.recover("w1", "its worker was lost", kNow)); };
  const auto claimed = got(jobs.claim_some("w1", at(50), at(110), 10));
  REQUIRE(claimed.size() == 3);
  const std::vector<Beat> beats{{claimed[0].token, meshgauge::server::store::Progress{0, 1, ""}},
                                {claimed[1].token, {}}};
  got(jobs.heartbeats(beats, at(300)));
  claimed_token(jobs, {"zoe", "single"});
  lose();
  CHECK(job_in(jobs, {"ann", "b/0"}).suspected);
  CHECK(job_in(jobs, {"ann", "b/0"}).last_error == "its worker was lost");
  CHECK_FALSE(job_in(jobs, {"ann", "b/1"}).suspected);
  CHECK(job_in(jobs, {"ann", "b/1"}).last_error.empty());
  CHECK_FALSE(job_in(jobs, {"ann", "b/2"}).suspected);
  CHECK(job_in(jobs, {"zoe", "single"}).suspected);

  claimed_token(jobs, {"ann", "b/0"});
  claimed_token(jobs, {"ann", "b/1"});
  lose();
  CHECK(job_in(jobs, {"ann", "b/0"}).suspected);
  CHECK_FALSE(job_in(jobs, {"ann", "b/1"}).suspected);
  // A job that ends its worker before it reports anything is excused only so often.
  for (unsigned lost = kMaxUnbegun; lost < kMaxUnbegun + kMaxTries; ++lost) {
    claimed_token(jobs, {"ann", "b/1"});
    lose();
    CHECK(job_in(jobs, {"ann", "b/1"}).suspected);
  }
  const Job poison = job_in(jobs, {"ann", "b/1"});
  CHECK(poison.state == JobState::failed);
  CHECK(poison.tries == kMaxUnbegun + kMaxTries);
  CHECK(poison.last_error == "its worker was lost");
}

namespace {

// A queue that claims by policy.h alone.
class QueueModel {
 public:
  void add(const NewJob& job) { jobs_.push_back({job, rank_of(job), false, false}); }
  void lose(const std::string& id) { at(id) = {at(id).job, at(id).rank, false, true}; }
  void end(const std::string& id) {
    std::erase_if(jobs_, [&](const Entry& entry) { return entry.job.key.id == id; });
  }

  Ids claim(std::size_t most) {
    const auto owner = next([](const Entry& entry) { return std::optional(entry.job.key.owner); });
    if (!owner) return {};
    const auto batch = next([&](const Entry& entry) {
      return entry.job.key.owner == *owner ? std::optional(entry.job.batch) : std::nullopt;
    });
    std::vector<Entry*> first;
    for (Entry& entry : jobs_) {
      if (!entry.running && entry.job.key.owner == *owner && entry.job.batch == *batch) first.push_back(&entry);
    }
    std::stable_sort(first.begin(), first.end(), [](const Entry* x, const Entry* y) { return x->rank < y->rank; });
    first.resize(std::min(first.size(), batch->empty() ? 1 : most));
    std::vector<Candidate> candidates;
    for (const Entry* entry : first) candidates.push_back({entry->job.cost, entry->suspected});
    first.resize(fit_in_claim(candidates));
    Ids ids;
    for (Entry* entry : first) {
      entry->running = true;
      ids.push_back(entry->job.key.id);
    }
    return ids;
  }

 private:
  struct Entry {
    NewJob job;
    std::int64_t rank = 0;
    bool running = false;
    bool suspected = false;
  };

  Entry& at(const std::string& id) {
    return *std::find_if(jobs_.begin(), jobs_.end(), [&](const Entry& entry) { return entry.job.key.id == id; });
  }

  template <class Name>
  std::optional<std::string> next(Name name_of) const {
    std::map<std::string, Group> waiting;
    for (const Entry& entry : jobs_) {
      const auto name = name_of(entry);
      if (!name || entry.running) continue;
      Group& group = waiting.try_emplace(*name, Group{*name, entry.rank, 0}).first->second;
      group.rank = std::min(group.rank, entry.rank);
    }
    for (const Entry& entry : jobs_) {
      const auto name = name_of(entry);
      if (name && entry.running && waiting.contains(*name)) ++waiting[*name].running;
    }
    std::vector<Group> groups;
    for (const auto& [name, group] : waiting) groups.push_back(group);
    const Group* const group = next_group(groups);
    return group ? std::optional(group->name) : std::nullopt;
  }

  std::vector<Entry> jobs_;
};

}  // namespace

TEST_CASE_TEMPLATE("claims: random queues are claimed in the order of the policy", Stores, EVERY_IMPLEMENTATION) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    CAPTURE(seed);
    Stores stores;
    JobStore& jobs = stores.jobs();
    QueueModel model;
    std::mt19937 random(seed);
    std::int64_t second = 0;
    const auto vary = [&](NewJob& job) {  // no two ranks are equal
      job.created = at(second++);
      job.cost = random() % 3 * 20'000'000 + random() % 1000;
      model.add(job);
    };
    for (int i = 0; i < 12; ++i) {
      const std::string owner(1, static_cast<char>('a' + random() % 3));
      const std::string id = owner + std::to_string(i);
      if (i % 2 == 0) {
        NewJob job = new_job(owner, id);
        vary(job);
        insert(jobs, job);
        continue;
      }
      NewBatch batch = new_batch(owner, id, 1 + random() % 8);
      for (BatchItem& item : batch.items) vary(item.job);
      insert(stores.batches(), batch);
    }
    std::vector<Token> running;
    while (true) {
      const std::size_t most = 1 + random() % 6;
      const auto claimed = got(jobs.claim_some("w1", at(50), at(110), most));
      Ids ids;
      for (const Claimed& one : claimed) {
        ids.push_back(one.token.key.id);
        running.push_back(one.token);
      }
      REQUIRE(ids == model.claim(most));
      if (ids.empty() && running.empty()) break;
      while (!running.empty() && (ids.empty() || random() % 2 == 0)) {
        const Token token = running[random() % running.size()];
        std::erase_if(running, [&](const Token& other) { return other.key == token.key; });
        const bool lost = random() % 3 == 0 && token.tries < kMaxTries;
        if (lost) CHECK(got(jobs.hand_back(token, "lost", kNow)) == JobState::queued);
        if (!lost) CHECK(got(finish(jobs, token, ending())));
        lost ? model.lose(token.key.id) : model.end(token.key.id);
        if (ids.empty()) break;
      }
    }
  }
}

TEST_CASE_TEMPLATE("claims: owners that have a running job are passed over on request", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  const auto claim = [&](JobStore::Clients clients) {
    const auto claimed = got(jobs.claim_some("w", at(50), at(110), 1, JobStore::Suspects::passed_over, clients));
    return claimed.empty() ? std::string() : claimed.front().job.key.owner;
  };
  using Clients = JobStore::Clients;
  for (const char* id : {"1", "2", "3"}) got(jobs.insert(new_job("ann", id)));
  CHECK(claim(Clients::with_none_running) == "ann");
  CHECK(claim(Clients::with_none_running).empty());
  got(jobs.insert(new_job("bob", "1")));
  CHECK(claim(Clients::with_none_running) == "bob");
  CHECK(claim(Clients::with_none_running).empty());
  CHECK(claim(Clients::all) == "ann");
}

TEST_CASE_TEMPLATE("claims: many heartbeats and endings at once, each by its own token", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert(stores.batches(), new_batch("ann", "b", 4));
  std::vector<Token> tokens;
  for (const Claimed& claimed : got(jobs.claim_some("w1", at(50), at(110), 4))) {
    tokens.push_back(claimed.token);
  }
  REQUIRE(tokens.size() == 4);
  got(jobs.hand_back(tokens[1], "x", kNow));
  got(jobs.request_cancel(tokens[2].key, kNow));
  const meshgauge::server::store::Progress progress{1, 2, "traverse"};
  const std::vector<Beat> beats{{tokens[0], progress}, {tokens[1], progress}, {tokens[2], {}}, {tokens[3], {}}};
  CHECK(got(jobs.heartbeats(beats, at(300))) ==
        std::vector{Heartbeat::go_on, Heartbeat::lost, Heartbeat::cancel, Heartbeat::go_on});
  CHECK(job_in(jobs, tokens[0].key).progress == progress);
  CHECK_FALSE(job_in(jobs, tokens[1].key).progress.has_value());
  const std::vector<Beat> silent{{tokens[0], {}}};
  got(jobs.heartbeats(silent, at(300)));
  CHECK(job_in(jobs, tokens[0].key).progress == progress);  // as it was
  CHECK(got(jobs.heartbeats({}, at(300))).empty());

  CHECK(got(jobs.recover(std::nullopt, "x", {at(299), at(1299)})).empty());  // the leases are renewed
  CHECK(job_in(jobs, tokens[3].key).state == JobState::running);

  std::vector<Finished> endings;
  for (const Token& token : tokens) endings.push_back({token, reusable("undecided")});
  endings[2].ending = ending(JobState::cancelled);
  const std::vector<bool> stored{true, false, true, true};
  CHECK(got(jobs.finish_all(endings)) == stored);
  CHECK(got(jobs.finish_all(endings)) == stored);  // the same call once more
  CHECK(got(jobs.finish_all({})).empty());
  CHECK(job_in(jobs, tokens[0].key).verdict == "undecided");
  CHECK(job_in(jobs, tokens[2].key).state == JobState::cancelled);
  CHECK(job_in(jobs, tokens[2].key).verdict.empty());
  CHECK(job_in(jobs, tokens[1].key).state == JobState::queued);
}

TEST_CASE_TEMPLATE("claims: verdict, deadline and batch are stored", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  NewJob job = new_job("ann", "1");
  job.deadline = at(77);
  insert(stores.jobs(), job);
  Job recorded = ended_job("ann", "2");
  recorded.verdict = "fail";
  recorded.deadline = at(78);
  stores.jobs().record(recorded);
  got(stores.jobs().flush());
  end(stores.jobs(), {"ann", "1"}, reusable("pass"));
  stores.reopen();
  const Job read = job_in(stores.jobs(), {"ann", "1"});
  CHECK(read.verdict == "pass");
  CHECK(read.deadline == at(77));
  CHECK(read.batch.empty());
  CHECK(job_in(stores.jobs(), {"ann", "2"}).verdict == "fail");
  CHECK(job_in(stores.jobs(), {"ann", "2"}).deadline == at(78));
}

TEST_CASE_TEMPLATE("claims: recovery requeues jobs of batches, and does not list them", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.batches(), new_batch("ann", "b", 3));
  CHECK(claim_ids(stores.jobs(), 2).size() == 2);
  stores.reopen();
  CHECK(got(stores.jobs().recover("", "the service ended while it ran", kNow)).empty());
  CHECK(batch_in(stores.batches(), {"ann", "b"}).counts.queued == 3);
}

TEST_CASE_TEMPLATE("meshes: many are looked up at once", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  for (const std::string id : {"a", "b", "c"}) {
    MeshRow row{{"ann", id}, 10, "model/stl", id + ".stl", at(0), at(0), at(100)};
    got(stores.meshes().put_mesh(row, {1000}));
  }
  got(stores.meshes().put_mesh({{"bob", "d"}, 10, "", "", at(0), at(0), at(100)}, {1000}));
  const std::vector<std::string> ids{"c", "d", "a", "a", "nothing"};
  std::set<std::string> known;
  const std::vector<MeshRow> rows = got(stores.meshes().known_meshes("ann", ids));
  for (const MeshRow& row : rows) {
    known.insert(row.key.id);
    CHECK(row.file_name == row.key.id + ".stl");
    CHECK(row.bytes == 10);
  }
  CHECK(rows.size() == 2);
  CHECK(known == std::set<std::string>{"a", "c"});
  CHECK(got(stores.meshes().known_meshes("ann", {})).empty());
}
