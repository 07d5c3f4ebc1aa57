#include "server/worker/claim_buffer.h"

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using Stage = HeldJob::Stage;

namespace {

const auto kNow = HeldJob::Clock::now();

HeldJobPtr ready(const std::string& name, const std::string& batch = "", std::uint64_t cost = 1000) {
  store::Job row;
  static_cast<store::NewJob&>(row) = job_named(name, batch, cost);
  auto job = std::make_shared<HeldJob>();
  job->live = live_job_of(row, one_worker(), {});
  job->in_batch = !batch.empty();
  job->stage = Stage::ready;
  job->claimed = kNow;
  return job;
}

std::string name_of(const HeldJobPtr& job) { return job ? job->live->key.id : ""; }

}  // namespace

TEST_CASE("claim buffer: as many begin as there are threads, jobs of no batch first") {
  ClaimBuffer buffer(2);
  for (const auto& job : {ready("b1", "b"), ready("b2", "b"), ready("single")}) buffer.add(job);
  const auto first = buffer.take(kNow);
  CHECK(name_of(first) == "single");
  CHECK(name_of(buffer.take(kNow)) == "b1");
  CHECK(buffer.take(kNow) == nullptr);
  buffer.ended(*first);
  CHECK(name_of(buffer.take(kNow)) == "b2");
}

TEST_CASE("claim buffer: a job that is not ready does not block others") {
  ClaimBuffer buffer(1);
  const auto slow = ready("slow");
  slow->stage = Stage::claimed;
  buffer.add(slow);
  buffer.add(ready("next"));
  CHECK(name_of(buffer.take(kNow)) == "next");
}

TEST_CASE("claim buffer: a small job of a batch is waited for while its blobs are opened, but not for long") {
  ClaimBuffer buffer(1);
  const auto quick = ready("quick", "b");
  quick->stage = Stage::opening;
  buffer.add(quick);
  const auto large = ready("large", "b", ClaimBuffer::kSmallBytes + 1);
  large->stage = Stage::opening;
  buffer.add(large);
  const auto next = ready("next", "b");
  buffer.add(next);
  CHECK(buffer.take(kNow) == nullptr);
  SUBCASE("it is ready in time") {
    quick->stage = Stage::ready;
    CHECK(buffer.take(kNow) == quick);
    buffer.ended(*quick);
    CHECK(buffer.take(kNow) == next);
  }
  SUBCASE("it is not") { CHECK(buffer.take(kNow + ClaimBuffer::kSoon) == next); }
  SUBCASE("it could not be opened") {
    quick->failures = 1;
    CHECK(buffer.take(kNow) == next);
  }
}

TEST_CASE("claim buffer: a suspected job that must wait for the end of others is not waited for") {
  ClaimBuffer buffer(2);
  buffer.add(ready("running", "b"));
  REQUIRE(buffer.take(kNow));
  const auto suspect = ready("suspect", "b");
  suspect->suspected = true;
  suspect->stage = Stage::opening;
  buffer.add(suspect);
  buffer.add(ready("next", "b"));
  CHECK(name_of(buffer.take(kNow)) == "next");
}

TEST_CASE("claim buffer: it is refilled before it is empty, for small jobs of batches alone") {
  ClaimBuffer buffer(2);
  CHECK(buffer.wanted() == ClaimBuffer::kMost);
  for (std::size_t i = 0; i < ClaimBuffer::kMost; ++i) buffer.add(ready("j" + std::to_string(i), "b"));
  CHECK(buffer.wanted() == 0);
  while (buffer.waiting() >= ClaimBuffer::kRefillBelow) {
    const auto job = buffer.take(kNow);
    REQUIRE(job);
    buffer.ended(*job);
  }
  CHECK(buffer.wanted() == ClaimBuffer::kMost - buffer.waiting());
  buffer.add(ready("large", "b", ClaimBuffer::kSmallBytes + 1));
  CHECK(buffer.wanted() == 0);
}

TEST_CASE("claim buffer: no more than idle threads when all may be busy for long") {
  ClaimBuffer buffer(2);
  buffer.add(ready("x"));
  REQUIRE(buffer.take(kNow));
  CHECK(buffer.wanted() > 0);
  buffer.add(ready("y"));
  CHECK(buffer.wanted() == 0);
  REQUIRE(buffer.take(kNow));
  CHECK(buffer.wanted() == 0);
}

TEST_CASE("claim buffer: a suspected job waits for all others, and nothing is claimed meanwhile") {
  ClaimBuffer buffer(4);
  const auto before = ready("before");
  buffer.add(before);
  REQUIRE(buffer.take(kNow));
  const auto suspect = ready("suspect");
  suspect->suspected = true;
  buffer.add(suspect);
  buffer.add(ready("after"));
  CHECK(buffer.wanted() == 0);
  const auto after = buffer.take(kNow);
  CHECK(name_of(after) == "after");
  CHECK(buffer.take(kNow) == nullptr);
  buffer.ended(*before);
  CHECK(buffer.take(kNow) == nullptr);
  buffer.ended(*after);
  CHECK(name_of(buffer.take(kNow)) == "suspect");
  buffer.add(ready("last"));
  CHECK(buffer.take(kNow) == nullptr);
  CHECK(buffer.wanted() == 0);
  buffer.ended(*suspect);
  CHECK(name_of(buffer.take(kNow)) == "last");
  CHECK(buffer.wanted() > 0);
}

TEST_CASE("claim buffer: a guest is wanted and begins while all threads are busy, one at a time") {
  ClaimBuffer buffer(1);
  CHECK(!buffer.wants_guest());  // any job can begin
  buffer.add(ready("busy"));
  const auto busy = buffer.take(kNow);
  REQUIRE(busy);
  CHECK(buffer.wanted() == 0);
  CHECK(buffer.wants_guest());
  const auto guest = ready("guest");
  guest->guest = true;
  buffer.add(guest);
  CHECK(!buffer.wants_guest());
  buffer.add(ready("next"));
  CHECK(buffer.take(kNow) == guest);
  CHECK(buffer.take(kNow) == nullptr);
  CHECK(!buffer.wants_guest());
  buffer.ended(*guest);
  CHECK(buffer.running() == 1);
  buffer.ended(*busy);
  CHECK(name_of(buffer.take(kNow)) == "next");
}
