#include "server/store/part_store.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "job_steps.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

using Ids = std::vector<std::string>;

std::vector<NewJob> parts_named(const std::string& whole, unsigned count) {
  std::vector<NewJob> parts;
  for (unsigned i = 0; i < count; ++i) {
    parts.push_back(new_job("ann", whole + "." + std::to_string(i)));
    parts.back().idempotency_key.clear();
  }
  return parts;
}

void insert_whole(PartStore& store, const std::string& id, unsigned count) {
  REQUIRE_FALSE(got(store.insert_parts(new_job("ann", id), parts_named(id, count))).existed);
}

std::optional<Claimed> next(JobStore& jobs) {
  auto claimed = got(jobs.claim_some("w", at(50), at(110), JobStore::Which::all, 10));
  if (claimed.empty()) return std::nullopt;
  REQUIRE(claimed.size() == 1);
  return std::move(claimed.front());
}

Token claimed_next(JobStore& jobs, const std::string& id) {
  auto claimed = next(jobs);
  REQUIRE(claimed.has_value());
  CHECK(claimed->token.key.id == id);
  return claimed->token;
}

void tell(JobStore& jobs, const Token& token, double lower, double upper) {
  CHECK(got(jobs.heartbeat(token, at(110), {lower, upper, "reduce"})) == Heartbeat::go_on);
}

JobState state_of(JobStore& jobs, const std::string& id) { return job_in(jobs, {"ann", id}).state; }

}  // namespace

TEST_CASE_TEMPLATE("parts: the whole is claimed when all have ended, and not before", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 3);
  CHECK(state_of(stores.jobs(), "w") == JobState::queued);
  CHECK_FALSE(got(stores.jobs().claim({"ann", "w"}, "w", at(50), at(110))).has_value());
  const Token first = claimed_next(stores.jobs(), "w.0");
  const Token second = claimed_next(stores.jobs(), "w.1");
  const Token third = claimed_next(stores.jobs(), "w.2");
  CHECK_FALSE(next(stores.jobs()).has_value());
  CHECK(got(stores.jobs().finish(first, ending())));
  CHECK(got(stores.jobs().finish(first, ending())));  // again counts once
  CHECK(got(stores.jobs().finish(second, ending(JobState::failed))));
  CHECK_FALSE(next(stores.jobs()).has_value());
  CHECK(got(stores.jobs().finish(third, ending(JobState::cancelled))));
  const Token whole = claimed_next(stores.jobs(), "w");
  const std::vector<Job> parts = got(stores.parts().parts({"ann", "w"}));
  REQUIRE(parts.size() == 3);
  for (unsigned i = 0; i < 3; ++i) CHECK(parts[i].key.id == "w." + std::to_string(i));
  CHECK(parts[0].document == ending().document);
  CHECK(parts[1].state == JobState::failed);
  CHECK(got(stores.parts().whole_of({"ann", "w.2"})) == "w");
  CHECK(got(stores.parts().whole_of({"ann", "w"})).empty());
  CHECK(got(stores.parts().parts({"bob", "w"})).empty());
  CHECK(got(stores.jobs().finish(whole, ending())));
  CHECK(got(stores.jobs().counts()).done == 1);  // its parts are in no count
}

TEST_CASE_TEMPLATE("parts: all are stored or none, and only once", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert(stores.jobs(), new_job("ann", "w.1"));
  CHECK_FALSE(stores.parts().insert_parts(new_job("ann", "w"), parts_named("w", 2)).ok());
  CHECK_FALSE(got(stores.jobs().get({"ann", "w"})).has_value());
  CHECK_FALSE(got(stores.jobs().get({"ann", "w.0"})).has_value());
  NewJob keyed = new_job("ann", "v");
  keyed.idempotency_key = "key";
  CHECK_FALSE(got(stores.parts().insert_parts(keyed, parts_named("v", 2))).existed);
  keyed.key.id = "u";
  Inserted again = got(stores.parts().insert_parts(keyed, parts_named("u", 2)));
  CHECK(again.existed);
  CHECK_FALSE(again.conflict);
  CHECK(again.job.key.id == "v");
  keyed.fingerprint = "another";
  CHECK(got(stores.parts().insert_parts(keyed, parts_named("u", 2))).conflict);
  CHECK_FALSE(got(stores.jobs().get({"ann", "u.0"})).has_value());
}

TEST_CASE_TEMPLATE("parts: they share what they tell, and the whole shows their interval", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 3);
  const JobKey whole{"ann", "w"};
  CHECK(got(stores.parts().best_lower(whole)) == 0);
  const Token first = claimed_next(stores.jobs(), "w.0");
  const Token second = claimed_next(stores.jobs(), "w.1");
  const double odd = 0.1 + 0.2;  // to the last bit
  tell(stores.jobs(), first, odd, 9);
  CHECK(got(stores.parts().best_lower(whole)) == odd);
  REQUIRE(job_in(stores.jobs(), whole).progress.has_value());
  CHECK(job_in(stores.jobs(), whole).progress->lower == odd);
  CHECK(std::isinf(job_in(stores.jobs(), whole).progress->upper));
  tell(stores.jobs(), second, 0.2, 7);
  CHECK(std::isinf(job_in(stores.jobs(), whole).progress->upper));  // of the third nothing is known
  CHECK(got(stores.jobs().finish(first, ending())));
  const Token third = claimed_next(stores.jobs(), "w.2");
  tell(stores.jobs(), third, 5, 8);
  CHECK(job_in(stores.jobs(), whole).progress == std::optional(Progress{5, 9, "reduce"}));
  CHECK(got(stores.parts().best_lower(whole)) == 5);
  CHECK(state_of(stores.jobs(), "w") == JobState::queued);
  // One that is lost has told nothing when it runs once more.
  got(stores.jobs().recover("w", "gone", kNow));
  CHECK(got(stores.parts().best_lower(whole)) == odd);
  const Token once_more = claimed_next(stores.jobs(), "w.1");
  CHECK(got(stores.jobs().heartbeat(second, at(110), {6, 7, "reduce"})) == Heartbeat::lost);
  CHECK(got(stores.parts().best_lower(whole)) == odd);
  tell(stores.jobs(), once_more, 0.4, 7);
  CHECK(got(stores.parts().best_lower(whole)) == 0.4);
  CHECK(got(stores.parts().best_lower({"bob", "w"})) == 0);
}

TEST_CASE_TEMPLATE("parts: who cancels the whole cancels them", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 3);
  const Token done = claimed_next(stores.jobs(), "w.0");
  CHECK(got(stores.jobs().finish(done, ending())));
  const Token running = claimed_next(stores.jobs(), "w.1");
  CHECK(got(stores.jobs().request_cancel({"ann", "w"}, kNow)) == JobState::cancelled);
  CHECK(state_of(stores.jobs(), "w.0") == JobState::done);
  CHECK(got(stores.jobs().heartbeat(running, at(110), {1, 2, "reduce"})) == Heartbeat::cancel);
  CHECK(state_of(stores.jobs(), "w.2") == JobState::cancelled);
  CHECK(got(stores.jobs().finish(running, ending(JobState::cancelled))));
  CHECK_FALSE(next(stores.jobs()).has_value());
  CHECK(state_of(stores.jobs(), "w") == JobState::cancelled);
}

TEST_CASE_TEMPLATE("parts: a part can be ended alone, and the whole sees it", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 2);
  const Token first = claimed_next(stores.jobs(), "w.0");
  CHECK(got(stores.jobs().request_cancel({"ann", "w.1"}, kNow)) == JobState::cancelled);
  CHECK(got(stores.jobs().finish(first, ending(JobState::failed))));
  claimed_next(stores.jobs(), "w");
}

TEST_CASE_TEMPLATE("parts: one that ends its workers is given up, and the whole hears of it", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 1);
  for (unsigned i = 0; i < kMaxTries; ++i) {
    claimed_next(stores.jobs(), "w.0");
    got(stores.jobs().recover("w", "its worker died", kNow));
  }
  claimed_next(stores.jobs(), "w");
  const std::vector<Job> parts = got(stores.parts().parts({"ann", "w"}));
  REQUIRE(parts.size() == 1);
  CHECK(parts[0].state == JobState::failed);
  CHECK(parts[0].last_error == "its worker died");
}

TEST_CASE_TEMPLATE("parts: they stay as long as their whole, and go with it", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 2);
  CHECK(got(stores.jobs().finish(claimed_next(stores.jobs(), "w.0"), ending())));
  got(stores.jobs().sweep_jobs({at(2000), at(3000)}, 0));  // its time is over, and there are too many
  CHECK(state_of(stores.jobs(), "w.0") == JobState::done);
  CHECK_FALSE(got(stores.jobs().forget({"ann", "w"})));
  CHECK(got(stores.jobs().finish(claimed_next(stores.jobs(), "w.1"), ending())));
  CHECK(got(stores.jobs().finish(claimed_next(stores.jobs(), "w"), ending())));
  CHECK(got(stores.jobs().forget({"ann", "w"})));
  CHECK(got(stores.parts().parts({"ann", "w"})).empty());
  CHECK_FALSE(got(stores.jobs().get({"ann", "w.1"})).has_value());
}

TEST_CASE_TEMPLATE("parts: those that nobody ran in time are given up, and the whole with them", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  insert_whole(stores.parts(), "w", 2);
  CHECK(got(stores.jobs().sweep_jobs({at(4000), at(9000)}, 100)).given_up == 1);
  for (const char* id : {"w", "w.0", "w.1"}) CHECK(state_of(stores.jobs(), id) == JobState::failed);
  CHECK(got(stores.jobs().sweep_jobs({at(9000), at(19000)}, 100)).expired == 1);
  for (const char* id : {"w", "w.0", "w.1"}) CHECK_FALSE(got(stores.jobs().get({"ann", id})).has_value());
}

TEST_CASE_TEMPLATE("parts: the interval of the whole only shrinks, whoever begins a part anew", Stores,
                   EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert_whole(stores.parts(), "w", 2);
  const auto whole = [&] { return job_in(jobs, {"ann", "w"}).progress; };
  const auto beat = [&](const Token& token, const Progress& progress) {
    CHECK(got(jobs.heartbeat(token, at(110), progress)) == Heartbeat::go_on);
  };
  const Token first = claimed_next(jobs, "w.0");
  const Token second = claimed_next(jobs, "w.1");
  beat(first, {3, 9, "reduce", "v1"});
  beat(second, {2, 7, "reduce", "v1"});
  CHECK(whole() == Progress{3, 9, "reduce", "v1"});
  CHECK(got(jobs.hand_back(first, "", kNow)) == JobState::queued);
  const Token again = claimed_next(jobs, "w.0");
  SUBCASE("of the same version") {
    beat(again, {0, std::numeric_limits<double>::infinity(), "build", "v1"});
    CHECK(whole() == Progress{3, 9, "build", "v1"});
    CHECK(got(stores.parts().best_lower({"ann", "w"})) == 2);  // it must find its own once more
    beat(again, {1, 8, "traverse", "v1"});
    CHECK(whole() == Progress{3, 8, "traverse", "v1"});
  }
  SUBCASE("of another version: what they have found is not mixed") {
    beat(again, {0, std::numeric_limits<double>::infinity(), "build", "v2"});
    CHECK(whole() == Progress{0, std::numeric_limits<double>::infinity(), "build", "v2"});
    beat(again, {1, 8, "traverse", "v2"});
    CHECK(whole() == Progress{1, std::numeric_limits<double>::infinity(), "traverse", "v2"});
    beat(second, {2.5, 7, "traverse", "v1"});
    CHECK(whole() == Progress{2.5, std::numeric_limits<double>::infinity(), "traverse", "v1"});
    CHECK(got(jobs.hand_back(second, "", kNow)) == JobState::queued);
    beat(claimed_next(jobs, "w.1"), {0.5, 6, "reduce", "v2"});
    CHECK(whole() == Progress{1, 8, "reduce", "v2"});
  }
}

TEST_CASE_TEMPLATE("parts: a whole and its parts are one job of their owner", Stores, EVERY_IMPLEMENTATION) {
  Stores stores;
  JobStore& jobs = stores.jobs();
  insert_whole(stores.parts(), "w", 3);
  insert(jobs, new_job("ann", "single"));
  const auto unended = [&] { return got(jobs.unended("ann", at(50))); };
  CHECK(unended() == 2);
  got(jobs.claim({"ann", "w.0"}, "w", at(50), at(110)));
  CHECK(unended() == 2);
  got(jobs.finish(claimed_token(jobs, {"ann", "w.1"}), ending()));
  got(jobs.finish(claimed_token(jobs, {"ann", "w.2"}), ending()));
  CHECK(unended() == 2);
  got(jobs.request_cancel({"ann", "w"}, kNow));
  CHECK(unended() == 1);
}
