#include "server/worker/claim_buffer.h"

#include "bench_of_workers.h"

using namespace meshgauge;
using namespace meshgauge::server;
using Stage = HeldJob::Stage;

namespace {

HeldJobPtr ready(const std::string& name, const std::string& batch = "", std::uint64_t cost = 1000) {
  store::Job row;
  static_cast<store::NewJob&>(row) = job_named(name, batch, cost);
  auto job = std::make_shared<HeldJob>();
  job->live = live_job_of(row, one_worker(), {});
  job->in_batch = !batch.empty();
  job->stage = Stage::ready;
  return job;
}

std::string name_of(const HeldJobPtr& job) { return job ? job->live->key.id : ""; }

}  // namespace

TEST_CASE("stock: as many begin as there are threads, those that somebody may wait for first") {
  Stock stock(2);
  for (const auto& job : {ready("b1", "b"), ready("b2", "b"), ready("single")}) stock.add(job);
  const auto first = stock.take();
  CHECK(name_of(first) == "single");
  CHECK(name_of(stock.take()) == "b1");
  CHECK(stock.take() == nullptr);
  stock.ended(*first);
  CHECK(name_of(stock.take()) == "b2");
}

TEST_CASE("stock: what is not ready does not hold up what is") {
  Stock stock(1);
  const auto slow = ready("slow");
  slow->stage = Stage::claimed;
  stock.add(slow);
  stock.add(ready("next"));
  CHECK(name_of(stock.take()) == "next");
}

TEST_CASE("stock: it is refilled before it is empty, from small jobs of batches alone") {
  Stock stock(2);
  CHECK(stock.wanted() == Stock::kMost);
  for (std::size_t i = 0; i < Stock::kMost; ++i) stock.add(ready("j" + std::to_string(i), "b"));
  CHECK(stock.wanted() == 0);
  while (stock.waiting() >= Stock::kRefillBelow) {
    const auto job = stock.take();
    REQUIRE(job);
    stock.ended(*job);
  }
  CHECK(stock.wanted() == Stock::kMost - stock.waiting());
  stock.add(ready("large", "b", Stock::kSmallBytes + 1));
  CHECK(stock.wanted() == 0);
}

TEST_CASE("stock: no more than there are idle threads when all of them may be busy for long") {
  Stock stock(2);
  stock.add(ready("x"));
  REQUIRE(stock.take());
  CHECK(stock.wanted() > 0);
  stock.add(ready("y"));
  CHECK(stock.wanted() == 0);
  REQUIRE(stock.take());
  CHECK(stock.wanted() == 0);
}

TEST_CASE("stock: one that is suspected waits for all that is there, and nothing is claimed meanwhile") {
  Stock stock(4);
  const auto before = ready("before");
  stock.add(before);
  REQUIRE(stock.take());
  const auto suspect = ready("suspect");
  suspect->suspected = true;
  stock.add(suspect);
  stock.add(ready("after"));
  CHECK(stock.wanted() == 0);
  const auto after = stock.take();
  CHECK(name_of(after) == "after");
  CHECK(stock.take() == nullptr);
  stock.ended(*before);
  CHECK(stock.take() == nullptr);
  stock.ended(*after);
  CHECK(name_of(stock.take()) == "suspect");
  stock.add(ready("last"));
  CHECK(stock.take() == nullptr);
  CHECK(stock.wanted() == 0);
  stock.ended(*suspect);
  CHECK(name_of(stock.take()) == "last");
  CHECK(stock.wanted() > 0);
}
