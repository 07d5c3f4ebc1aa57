#include "server/store/part_store.h"

#include "job_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

struct Whole {
  NewJob job = new_job("ann", "whole");
  std::vector<NewJob> parts{new_job("ann", "p0"), new_job("ann", "p1"), new_job("ann", "p2")};
};

template <class Stores>
Whole inserted(Stores& stores) {
  Whole whole;
  REQUIRE_FALSE(got(stores.parts().insert_parts(whole.job, whole.parts)).existed);
  return whole;
}

void end_part(JobStore& jobs, const std::string& id, JobState state = JobState::done) {
  REQUIRE(got(jobs.finish(claimed_token(jobs, {"ann", id}), ending(state))));
}

bool can_be_claimed(JobStore& jobs, const std::string& id) {
  return got(jobs.claim({"ann", id}, "w9", at(50), at(110))).has_value();
}

}  // namespace

TEST_CASE_TEMPLATE("parts: the whole can be claimed when all of them have ended, however", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  inserted(stores);
  std::vector<std::string> ids;
  for (const Job& part : got(stores.parts().parts({"ann", "whole"}))) ids.push_back(part.key.id);
  CHECK(ids == std::vector<std::string>{"p0", "p1", "p2"});
  CHECK(got(stores.parts().parts({"ann", "p0"})).empty());
  CHECK(got(stores.parts().parts({"bob", "whole"})).empty());
  CHECK(got(stores.parts().whole_of({"ann", "p1"})) == "whole");
  CHECK(got(stores.parts().whole_of({"ann", "whole"})).empty());

  end_part(jobs, "p0");
  CHECK_FALSE(can_be_claimed(jobs, "whole"));
  const Token once = claimed_token(jobs, {"ann", "p1"});
  CHECK(got(jobs.hand_back(once, "its worker died", kNow)) == JobState::queued);
  const Token twice = claimed_token(jobs, {"ann", "p1"});
  CHECK(got(jobs.finish(twice, ending(JobState::failed))));
  CHECK(got(jobs.finish(twice, ending(JobState::failed))));  // the same call once more counts once
  CHECK_FALSE(can_be_claimed(jobs, "whole"));
  CHECK(got(jobs.request_cancel({"ann", "p2"}, kNow)) == JobState::cancelled);
  CHECK(can_be_claimed(jobs, "whole"));
}

TEST_CASE_TEMPLATE("parts: one that is given up ends too", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  inserted(stores);
  end_part(jobs, "p0");
  end_part(jobs, "p1");
  for (unsigned i = 0; i < kMaxTries; ++i) {
    CHECK_FALSE(can_be_claimed(jobs, "whole"));
    claimed_token(jobs, {"ann", "p2"}, "host/1");
    got(jobs.recover("host/", "its worker died", kNow));
  }
  CHECK(job_in(jobs, {"ann", "p2"}).state == JobState::failed);
  CHECK(can_be_claimed(jobs, "whole"));
}

TEST_CASE_TEMPLATE("parts: who cancels the whole cancels them", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  inserted(stores);
  end_part(jobs, "p0");
  const Token runs = claimed_token(jobs, {"ann", "p1"});
  CHECK(got(jobs.request_cancel({"ann", "whole"}, kNow)) == JobState::cancelled);
  CHECK(job_in(jobs, {"ann", "p0"}).state == JobState::done);
  CHECK(job_in(jobs, {"ann", "p2"}).state == JobState::cancelled);
  CHECK(got(jobs.heartbeat(runs, at(170), {})) == Heartbeat::cancel);
  CHECK(got(jobs.finish(runs, ending(JobState::cancelled))));
  CHECK(job_in(jobs, {"ann", "whole"}).state == JobState::cancelled);
}

TEST_CASE_TEMPLATE("parts: all or none, and the same call once more", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  Whole whole;
  whole.job.idempotency_key = "k";
  insert(stores.jobs(), new_job("ann", "p1"));
  CHECK_FALSE(stores.parts().insert_parts(whole.job, whole.parts).ok());  // another job has that id
  CHECK_FALSE(got(stores.jobs().get({"ann", "whole"})).has_value());
  whole.parts[1].key.id = "p9";
  CHECK_FALSE(got(stores.parts().insert_parts(whole.job, whole.parts)).existed);
  const Inserted again = got(stores.parts().insert_parts(whole.job, whole.parts));
  CHECK(again.existed);
  CHECK_FALSE(again.conflict);
  CHECK(got(stores.parts().parts({"ann", "whole"})).size() == 3);
}

TEST_CASE_TEMPLATE("parts: they go with the whole, and are in no count", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  inserted(stores);
  CHECK(got(jobs.counts()).queued == 1);
  for (const char* id : {"p0", "p1", "p2", "whole"}) end_part(jobs, id);
  CHECK(got(jobs.counts()).done == 1);
  SUBCASE("forgotten") { CHECK(got(jobs.forget({"ann", "whole"}))); }
  SUBCASE("expired") { CHECK(got(jobs.sweep_jobs({at(5000), at(9000)}, 100)).expired == 1); }
  SUBCASE("beyond the cap") { CHECK(got(jobs.sweep_jobs({at(200), at(9000)}, 0)).over_cap == 1); }
  for (const char* id : {"p0", "p1", "p2", "whole"}) CHECK_FALSE(got(jobs.get({"ann", id})).has_value());
}

TEST_CASE_TEMPLATE("parts: those that nobody ran in time are given up, and the whole with them", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  inserted(stores);
  CHECK(got(stores.jobs().sweep_jobs({at(4000), at(9000)}, 100)).given_up == 1);
  for (const char* id : {"p0", "p1", "p2", "whole"}) {
    CHECK(job_in(stores.jobs(), {"ann", id}).state == JobState::failed);
  }
}
