#include "server/jobs/sweep_guard.h"

#include <ctime>
#include <string>
#include <utility>

#include "api/utc.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;

constexpr std::chrono::hours kBetweenLines{1};

}  // namespace

milliseconds system_uptime() {
  timespec time{};
  ::clock_gettime(CLOCK_BOOTTIME, &time);
  return std::chrono::seconds(time.tv_sec) +
         std::chrono::duration_cast<milliseconds>(std::chrono::nanoseconds(time.tv_nsec));
}

SweepGuard::SweepGuard(const Stores& stores, StoreErrors& store_errors, Uptime uptime)
    : stores_(stores), store_errors_(store_errors), uptime_(std::move(uptime)), offset_(offset()) {}

milliseconds SweepGuard::offset() const { return stores_.jobs.time().time_since_epoch() - uptime_(); }

bool SweepGuard::clock_is_steady() {
  const milliseconds uptime = uptime_();
  const milliseconds offset = this->offset();
  const milliseconds jump = offset - offset_;
  if (jump >= -kJump && jump <= kJump) {
    if (jumped_) log_event("sweep", "the clock is right again: sweeps go on");
    jumped_.reset();
    offset_ = offset;
    return true;
  }
  if (!jumped_) {
    jumped_ = uptime;
    log_event("sweep", "the clock jumped by " + std::to_string(jump.count() / 1000) +
                           " s: nothing that looks expired is removed until it is right again, or for a day");
  }
  if (uptime - *jumped_ < kGrace) return false;
  log_event("sweep", "the clock has been as it is for a day: sweeps go on by it");
  jumped_.reset();
  offset_ = offset;
  return true;
}

bool SweepGuard::may_remove(const store::UnusedBlobs& unused, std::chrono::seconds older_than) {
  const auto origin = stores_.jobs.origin();
  store_errors_.note(origin);
  if (!origin || has_grace(unused, older_than, *origin)) return false;
  next_line_.reset();
  if (!origin->doubted) return true;
  if (unused.number == 0) {
    store_errors_.note(stores_.jobs.doubt(std::nullopt));
    return true;
  }
  log_event("sweep", "removing " + std::to_string(unused.number) + " stored files that the database did not know");
  return true;
}

bool SweepGuard::has_grace(const store::UnusedBlobs& unused, std::chrono::seconds older_than,
                           const store::Origin& origin) {
  const store::TimePoint now = stores_.jobs.time();
  if (unused.number > 0 && unused.oldest < origin.born && now < origin.born + kGrace) {
    say(unused, origin.born + kGrace, "some are older than the database, which is new: was it lost?");
    return true;
  }
  if (unused.number == 0 || (!origin.doubted && (unused.number < kMostUnknown || !are_unknown(older_than))))
    return false;
  if (!origin.doubted) store_errors_.note(stores_.jobs.doubt(now));
  const store::TimePoint until = origin.doubted.value_or(now) + kGrace;
  if (now >= until) return false;
  say(unused, until, "crashes leave fewer: was the database lost or restored?");
  return true;
}

// Many that ended jobs have used are no reason for doubt.
bool SweepGuard::are_unknown(std::chrono::seconds older_than) {
  const auto known = stores_.jobs.known_blobs();
  store_errors_.note(known);
  if (!known) return true;
  const auto unknown = stores_.blobs.count_unused(*known, older_than);
  store_errors_.note(unknown);
  return !unknown || unknown->number >= kMostUnknown;
}

void SweepGuard::say(const store::UnusedBlobs& unused, store::TimePoint until, const std::string& why) {
  const milliseconds uptime = uptime_();
  if (next_line_ && uptime < *next_line_) return;
  next_line_ = uptime + kBetweenLines;
  log_event("sweep", std::to_string(unused.number) + " stored files are unknown to the database; " + why +
                         " They are removed after " + api::to_utc_ms(until));
}

}  // namespace meshgauge::server
