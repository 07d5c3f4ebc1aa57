#include "server/handlers/readiness.h"

#include <algorithm>
#include <new>
#include <system_error>

#include "engine/hausdorff.h"

namespace meshgauge::server {
namespace {

std::string defect_of(const auto& result) { return result ? std::string() : result.error().message; }

void send_status(Exchange& exchange, const char* status) {
  exchange.response.content_type = "application/json";
  exchange.response.body = std::string(R"({"status":")") + status + R"(","version":")" + version() + "\"}";
}

}  // namespace

void Readiness::watch_stores(const Stores& stores) {
  const bool shared = stores.shared;
  watch(shared ? "database" : "store", [stores] { return defect_of(stores.jobs.check()); });
  watch(shared ? "blobs" : "disk", [stores] { return defect_of(stores.blobs.check()); });
}

Readiness::~Readiness() {
  if (check_.valid()) check_.wait();
}

void Readiness::answer(Exchange& exchange, Defects now) {
  api::Problem problem{api::ProblemKind::not_ready, "", {}};
  for (auto& defect : seen()) now.push_back(std::move(defect));
  for (const auto& [part, message] : now) {
    problem.errors.push_back({part, "", message});
    problem.detail += (problem.detail.empty() ? "" : "; ") + message;
  }
  if (!problem.errors.empty()) return server::answer(exchange, problem);
  send_status(exchange, "ready");
}

// Anybody may ask, and each look costs the disk a write: it counts for a second. Whoever begins a look waits for it,
// for a while; the others are told what was seen before.
Readiness::Defects Readiness::seen() {
  std::unique_lock lock(mutex_);
  if (looking_) return late_ ? late() : defects_;
  if (Clock::now() < looked_ + std::chrono::seconds(1)) return defects_;
  begin_look();
  late_ = !looked_at_.wait_for(lock, timeout_, [this] { return !looking_; });
  return late_ ? late() : defects_;
}

// Under the lock, which a look that has ended does not need any more.
void Readiness::begin_look() {
  looking_ = true;
  late_ = false;
  at_ = "service";  // until its thread has come to the first part
  try {
    check_ = std::async(std::launch::async, [this] { check(); });
  } catch (const std::exception&) {
    looking_ = false;
    looked_ = Clock::now();
    defects_ = {{"service", "it has no thread or no memory to spare"}};
  }
}

void Readiness::check() {
  Defects seen;
  try {
    seen = find_defects();
  } catch (const std::bad_alloc&) {
    seen = {{"service", "memory ran out"}};
  } catch (const std::exception&) {  // else it would be looked at for ever
    seen = {{"service", "it could not look"}};
  }
  const std::lock_guard lock(mutex_);
  looking_ = false;
  defects_ = std::move(seen);
  looked_ = Clock::now();
  looked_at_.notify_all();
}

Readiness::Defects Readiness::find_defects() {
  Defects seen;
  for (const auto& [part, defect_of] : looks_) {
    {
      const std::lock_guard lock(mutex_);
      at_ = part;
    }
    std::string defect = defect_of();
    const bool told = std::any_of(seen.begin(), seen.end(), [&](const auto& other) { return other.second == defect; });
    if (!defect.empty() && !told) seen.emplace_back(part, std::move(defect));
  }
  return seen;
}

void answer_health(Exchange& exchange) { send_status(exchange, "ok"); }

}  // namespace meshgauge::server
