#include "server/readiness.h"

#include <new>

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
  watch("store", [stores] { return defect_of(stores.jobs.check()); });
  watch("disk", [stores] { return defect_of(stores.blobs.check()); });
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

// Anybody may ask, and each look costs the disk a write: it counts for a second. A disk or a reader that does not
// answer holds up one who asks, not all: the others are told what was seen before.
Readiness::Defects Readiness::seen() {
  {
    const std::lock_guard lock(mutex_);
    if (looking_ || Clock::now() < looked_ + std::chrono::seconds(1)) return defects_;
    looking_ = true;
  }
  Defects seen;
  try {
    seen = look();
  } catch (const std::bad_alloc&) {
    seen = {{"service", "memory ran out"}};
  }
  const std::lock_guard lock(mutex_);
  looking_ = false;
  defects_ = std::move(seen);
  looked_ = Clock::now();
  return defects_;
}

Readiness::Defects Readiness::look() const {
  Defects seen;
  for (const auto& [part, defect_of] : looks_) {
    if (std::string defect = defect_of(); !defect.empty()) seen.emplace_back(part, std::move(defect));
  }
  return seen;
}

void answer_health(Exchange& exchange) { send_status(exchange, "ok"); }

}  // namespace meshgauge::server
