#include "server/http/descriptors.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "api/base/refused.h"

namespace meshgauge::server {
namespace {

// For each of `workers` and `queue`: four, the files of two uploads, open and mapped; and one for the quarter of places
// that there may be beyond them (share.h).
constexpr std::uint64_t kOfEachPlace = 5;
constexpr std::uint64_t kOfEachReader = 6;  // two channels and the files of its arrays, and a process that is ready
constexpr std::uint64_t kOfStores = 100;    // their connections and files, the log, what listens
constexpr std::uint64_t kLeastConnections = 64;
constexpr std::uint64_t kMostConnections = 100'000;

// Raises the limit and returns it. Without a limit: more than a process can use.
std::uint64_t raised_limit() {
  constexpr std::uint64_t kNone = 4 * kMostConnections;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return kNone;
  const rlim_t granted = std::exchange(limit.rlim_cur, limit.rlim_max);
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0) limit.rlim_cur = granted;
  return limit.rlim_cur == RLIM_INFINITY ? kNone : limit.rlim_cur;
}

std::string needs_text(const Settings& settings, std::uint64_t needed) {
  return std::to_string(needed) + " descriptors (" + std::to_string(kOfEachPlace) + " for each of workers (" +
         std::to_string(settings.workers) + ") and queue (" + std::to_string(settings.queue) + "), " +
         std::to_string(kOfEachReader) + " for each of parsers (" + std::to_string(settings.parsers) + "), " +
         std::to_string(kOfStores) + " for the stores" +
         (settings.status_port > 0 ? ", " + std::to_string(kStatusConnections) + " for the status port)" : ")");
}

}  // namespace

DescriptorPlan planned(const Settings& settings, std::uint64_t limit) {
  DescriptorPlan plan;
  plan.limit = limit;
  plan.needed = kOfEachPlace * (settings.workers + settings.queue) + kOfEachReader * settings.parsers + kOfStores;
  if (settings.status_port > 0) plan.needed += kStatusConnections;
  const std::uint64_t left = limit - std::min(limit, plan.needed);
  if (left >= kLeastConnections) plan.connections = std::min({kMostConnections, limit / 4 * 3, left});
  return plan;
}

DescriptorPlan plan_descriptors(const Settings& settings) { return planned(settings, raised_limit()); }

Result<Done> check_descriptors(const Settings& settings) {
  const DescriptorPlan plan = plan_descriptors(settings);
  if (plan.connections > 0) return Done{};
  return refused("the limit on open files is " + std::to_string(plan.limit) + ", but these settings need " +
                 needs_text(settings, plan.needed) + ", and connections " + std::to_string(kLeastConnections) +
                 " more: raise it (ulimit -Hn, LimitNOFILE, --ulimit nofile), or lower --queue, --workers, --parsers");
}

std::string descriptors_text(const Settings& settings) {
  const DescriptorPlan plan = plan_descriptors(settings);
  const bool lowered = plan.connections < std::min(kMostConnections, plan.limit / 4 * 3);
  return "the settings need " + needs_text(settings, plan.needed) + " of " + std::to_string(plan.limit) + "; at most " +
         std::to_string(plan.connections) + " connections" +
         (lowered ? ", fewer than three quarters of the limit, which is low (ulimit -Hn)" : "");
}

}  // namespace meshgauge::server
