// Every event in every state of a job: the table of server/store/README.md, over each store.
#include <array>
#include <functional>
#include <map>

#include "batch_steps.h"

using namespace meshgauge::server::store;

namespace {

const JobKey kJob{"ann", "b/0"};
const JobKey kBatch{"ann", "b"};
const Moment kSweep{at(3600), at(9000)};  // when a queued job has waited too long, and ended ones have expired

// A store with one job, of no batch or of one, and the newest token of the job.
struct World {
  JobStore& jobs;
  BatchStore& batches;
  bool in_batch = false;
  Token token{kJob, "w1", 1};
};

void insert_job(World& world) {
  if (world.in_batch) insert(world.batches, new_batch("ann", "b", 1));
  if (!world.in_batch) insert(world.jobs, new_job(kJob.owner, kJob.id));
}

// The states of the table: `cancelling` runs and is to be cancelled, `last` runs for the last time.
constexpr std::array kStates{"unknown", "queued", "running", "cancelling", "last", "done", "failed", "cancelled"};

void bring_to(World& world, const std::string& state) {
  if (state == "unknown") return;
  insert_job(world);
  if (state == "queued") return;
  for (unsigned i = 1; state == "last" && i < kMaxTries; ++i) {
    got(world.jobs.hand_back(claimed_token(world.jobs, kJob), "failed", kNow));
  }
  world.token = claimed_token(world.jobs, kJob);
  if (state == "cancelling" || state == "cancelled") got(world.jobs.request_cancel(kJob, kNow));
  for (const JobState end : {JobState::done, JobState::failed, JobState::cancelled}) {
    if (state == kStates[5 + static_cast<std::size_t>(end) - static_cast<std::size_t>(JobState::done)]) {
      REQUIRE(got(finish(world.jobs, world.token, ending(end))));
    }
  }
}

std::string text_of(JobState state) {
  return std::map<JobState, std::string>{{JobState::queued, "queued"},
                                         {JobState::running, "running"},
                                         {JobState::done, "done"},
                                         {JobState::failed, "failed"},
                                         {JobState::cancelled, "cancelled"}}[state];
}
std::string text_of(const std::optional<JobState>& state) { return state ? text_of(*state) : "no"; }
std::string text_of(bool yes) { return yes ? "yes" : "no"; }

std::string state_in(JobStore& jobs) {
  const std::optional<Job> job = got(jobs.get(kJob));
  if (!job) return "unknown";
  return job->state == JobState::running && job->cancel_requested ? "cancelling" : text_of(job->state);
}

std::string beat(JobStore& jobs, const Token& token) {
  const Heartbeat heard = got(heartbeat(jobs, token, at(500), {1, 2, "traverse", "v1"}));
  return heard == Heartbeat::lost ? "lost" : heard == Heartbeat::cancel ? "cancel" : "go on";
}

std::string recover(JobStore& jobs, const std::optional<std::string>& dead_workers, TimePoint now) {
  got(jobs.recover(dead_workers, "its worker was lost", {now, at(1000)}));
  return "-";
}

Token older(Token token) {
  token.worker = "w0";
  return token;
}

struct Event {
  std::string name;
  std::function<std::string(World&)> happen;
  std::array<std::string, kStates.size()> expected;  // "ANSWER > STATE", for each of kStates; -: no answer
  std::map<std::string, std::string> in_batch = {};  // where that is another one for a job of a batch
};

std::vector<Event> events_of_workers() {
  using W = World;
  const auto later = [] {
    Ending other = ending();
    other.finished = at(121);
    return other;
  };
  return {
      {"claim",
       [](W& w) { return text_of(!got(w.jobs.claim_some("w2", at(60), at(120), 1)).empty()); },
       {"no > unknown", "yes > running", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"}},
      {"heartbeat",
       [](W& w) { return beat(w.jobs, w.token); },
       {"lost > unknown", "lost > queued", "go on > running", "cancel > cancelling", "go on > running", "lost > done",
        "lost > failed", "lost > cancelled"}},
      {"heartbeat, older token",
       [](W& w) { return beat(w.jobs, older(w.token)); },
       {"lost > unknown", "lost > queued", "lost > running", "lost > cancelling", "lost > running", "lost > done",
        "lost > failed", "lost > cancelled"}},
      {"finish",
       [](W& w) { return text_of(got(finish(w.jobs, w.token, ending()))); },
       {"no > unknown", "no > queued", "yes > done", "yes > done", "yes > done", "yes > done", "no > failed",
        "no > cancelled"}},
      {"finish, another end",
       [later](W& w) { return text_of(got(finish(w.jobs, w.token, later()))); },
       {"no > unknown", "no > queued", "yes > done", "yes > done", "yes > done", "no > done", "no > failed",
        "no > cancelled"}},
      {"finish, older token",
       [](W& w) { return text_of(got(finish(w.jobs, older(w.token), ending()))); },
       {"no > unknown", "no > queued", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"}},
      {"hand_back",
       [](W& w) { return text_of(got(w.jobs.hand_back(w.token, "failed", kNow))); },
       {"no > unknown", "no > queued", "queued > queued", "cancelled > cancelled", "failed > failed", "no > done",
        "no > failed", "no > cancelled"}},
      {"hand_back, excused",
       [](W& w) { return text_of(got(w.jobs.hand_back(w.token, "", kNow))); },
       {"no > unknown", "no > queued", "queued > queued", "cancelled > cancelled", "queued > queued", "no > done",
        "no > failed", "no > cancelled"}},
      {"hand_back, older token",
       [](W& w) { return text_of(got(w.jobs.hand_back(older(w.token), "failed", kNow))); },
       {"no > unknown", "no > queued", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"}},
  };
}

std::vector<Event> other_events() {
  using W = World;
  return {
      {"insert",
       [](W& w) { return text_of(!got(w.jobs.insert(new_job(kJob.owner, kJob.id))).existed); },
       {"yes > queued", "no > queued", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"}},
      {"record",
       [](W& w) {
         w.jobs.record(ended_job(kJob.owner, kJob.id));
         got(w.jobs.flush());
         return std::string("-");
       },
       {"- > done", "- > queued", "- > running", "- > cancelling", "- > running", "- > done", "- > failed",
        "- > cancelled"}},
      {"recover, lease not over",
       [](W& w) { return recover(w.jobs, std::nullopt, at(109)); },
       {"- > unknown", "- > queued", "- > running", "- > cancelling", "- > running", "- > done", "- > failed",
        "- > cancelled"}},
      {"recover, lease over",
       [](W& w) { return recover(w.jobs, std::nullopt, at(110)); },
       {"- > unknown", "- > queued", "- > queued", "- > cancelled", "- > failed", "- > done", "- > failed",
        "- > cancelled"}},
      {"recover, worker dead",
       [](W& w) { return recover(w.jobs, "w1", at(60)); },
       {"- > unknown", "- > queued", "- > queued", "- > cancelled", "- > failed", "- > done", "- > failed",
        "- > cancelled"}},
      {"request_cancel",
       [](W& w) { return text_of(got(w.jobs.request_cancel(kJob, kNow))); },
       {"no > unknown", "cancelled > cancelled", "running > cancelling", "running > cancelling", "running > cancelling",
        "done > done", "failed > failed", "cancelled > cancelled"}},
      {"cancel_batch",
       [](W& w) { return text_of(got(w.batches.cancel_batch(kBatch, kNow))); },
       {"no > unknown", "no > queued", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"},
       {{"queued", "yes > cancelled"},
        {"running", "yes > cancelling"},
        {"cancelling", "yes > cancelling"},
        {"last", "yes > cancelling"},
        {"done", "yes > done"},
        {"failed", "yes > failed"},
        {"cancelled", "yes > cancelled"}}},
      {"sweep_jobs",
       [](W& w) {
         got(w.jobs.sweep_jobs(kSweep, 100));
         return std::string("-");
       },
       {"- > unknown", "- > failed", "- > running", "- > cancelling", "- > running", "- > unknown", "- > unknown",
        "- > unknown"},
       {{"done", "- > done"}, {"failed", "- > failed"}, {"cancelled", "- > cancelled"}}},
      {"forget",
       [](W& w) { return text_of(got(w.jobs.forget(kJob))); },
       {"no > unknown", "no > queued", "no > running", "no > cancelling", "no > running", "yes > unknown",
        "yes > unknown", "yes > unknown"}},
      {"forget_batch",
       [](W& w) { return text_of(got(w.batches.forget_batch(kBatch))); },
       {"no > unknown", "no > queued", "no > running", "no > cancelling", "no > running", "no > done", "no > failed",
        "no > cancelled"},
       {{"done", "yes > unknown"}, {"failed", "yes > unknown"}, {"cancelled", "yes > unknown"}}},
  };
}

void remove_job(JobStore& jobs, BatchStore& batches) {
  got(jobs.request_cancel(kJob, kNow));
  got(jobs.recover("", "the test is over", kNow));
  got(jobs.forget(kJob));
  got(batches.forget_batch(kBatch));
  REQUIRE(state_in(jobs) == "unknown");
}

template <class Stores>
void check_all(const std::vector<Event>& events) {
  Stores stores;
  for (const bool in_batch : {false, true}) {
    for (const Event& event : events) {
      for (std::size_t state = 0; state < kStates.size(); ++state) {
        World world{stores.jobs(), stores.batches(), in_batch};
        bring_to(world, kStates[state]);
        const auto other = event.in_batch.find(kStates[state]);
        const bool differs = in_batch && other != event.in_batch.end();
        const std::string answer = event.happen(world);
        INFO(event.name, " of a job that is ", kStates[state], in_batch ? ", in a batch" : "");
        CHECK(answer + " > " + state_in(world.jobs) == (differs ? other->second : event.expected[state]));
        remove_job(stores.jobs(), stores.batches());
      }
    }
  }
}

}  // namespace

TEST_CASE_TEMPLATE("transitions: every event of a worker in every state", Stores, EVERY_IMPLEMENTATION) {
  check_all<Stores>(events_of_workers());
}

TEST_CASE_TEMPLATE("transitions: every event of clients and of upkeep in every state", Stores, EVERY_IMPLEMENTATION) {
  check_all<Stores>(other_events());
}
