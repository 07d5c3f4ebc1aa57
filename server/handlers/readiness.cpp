#include "server/handlers/readiness.h"

#include <algorithm>
#include <new>
#include <utility>

#include "engine/hausdorff.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

std::string defect_of(const auto& result) { return result ? std::string() : result.error().message; }

void send_status(Exchange& exchange, const char* status) {
  answer_with(exchange, std::string(R"({"status":")") + status + R"(","version":")" + version() + "\"}");
}

}  // namespace

void Readiness::add_store_checks(const Stores& stores) {
  const bool shared = stores.shared;
  add_check(
      shared ? "database" : "store", [stores] { return defect_of(stores.jobs.check()); }, stores.place);
  add_check(
      shared ? "blobs" : "disk", [stores] { return defect_of(stores.blobs.check()); }, stores.place);
}

Readiness::~Readiness() {
  if (running_checks_.valid()) running_checks_.wait();
}

void Readiness::answer(Exchange& exchange, Defects now) {
  api::Problem problem{api::ProblemKind::not_ready, ""};
  for (auto& defect : last_defects()) now.push_back(std::move(defect));
  for (const auto& [part, message] : now) {
    problem.errors.push_back({part, "", message});
    problem.detail += (problem.detail.empty() ? "" : "; ") + message;
  }
  if (!problem.errors.empty()) return server::answer(exchange, problem);
  send_status(exchange, "ready");
}

Readiness::Defects Readiness::overdue() const {
  const std::string part(current_part_);
  return {
      {current_part_, "the check of '" + part + "' did not end within " + std::to_string(timeout_.count()) + " ms"}};
}

// Anyone may ask for /readyz without a key, and each round of checks writes to the disk: hence once a second at most.
Readiness::Defects Readiness::last_defects() {
  std::unique_lock lock(mutex_);
  if (checking_) return overdue_ ? overdue() : defects_;
  if (Clock::now() < checked_at_ + std::chrono::seconds(1)) return defects_;
  start_checks();
  overdue_ = !checks_ended_.wait_for(lock, timeout_, [this] { return !checking_; });
  return overdue_ ? overdue() : defects_;
}

// Under the lock. Assigning to running_checks_ waits for the thread before, which does not need the lock any more.
void Readiness::start_checks() {
  checking_ = true;
  overdue_ = false;
  current_part_ = "service";  // until the thread has come to the first part
  try {
    running_checks_ = std::async(std::launch::async, [this] { run_checks(); });
  } catch (const std::exception&) {
    checking_ = false;
    checked_at_ = Clock::now();
    defects_ = {{"service", "no thread or memory is left for a check"}};
  }
}

void Readiness::run_checks() {
  Defects found;
  try {
    found = find_defects();
  } catch (const std::bad_alloc&) {
    found = {{"service", "out of memory during a check"}};
  } catch (const std::exception&) {  // else checking_ would stay set for ever
    found = {{"service", "a check failed unexpectedly"}};
  }
  const std::lock_guard lock(mutex_);
  checking_ = false;
  defects_ = std::move(found);
  checked_at_ = Clock::now();
  checks_ended_.notify_all();
}

void Readiness::tell(Check& check, const std::string& defect) {
  const bool fails = !defect.empty();
  if (std::exchange(check.failed, fails) == fails) return;
  log_event("readiness", std::string(check.part) + ": " + (fails ? located(defect, check.place) : "well again"));
}

Readiness::Defects Readiness::find_defects() {
  Defects found;
  for (Check& check : checks_) {
    {
      const std::lock_guard lock(mutex_);
      current_part_ = check.part;
    }
    std::string defect = check.find_defect();
    tell(check, defect);
    const bool known =
        std::any_of(found.begin(), found.end(), [&](const auto& other) { return other.second == defect; });
    if (!defect.empty() && !known) found.emplace_back(check.part, std::move(defect));
  }
  return found;
}

void add_status_routes(Router& router, const Metrics& metrics, Router::Action ready) {
  const auto add = [&router](const char* path, Router::Action action) {
    Router::Route& route = router.add("GET", path, std::move(action));
    route.status = true;
    route.takes_query = true;
  };
  add("/healthz", [](Exchange& exchange) { send_status(exchange, "ok"); });
  add("/readyz", std::move(ready));
  add("/metrics",
      [&metrics](Exchange& exchange) { answer_with(exchange, metrics.text(), 200, Metrics::kContentType); });
}

}  // namespace meshgauge::server
