#include "server/jobs/upkeep.h"

#include <algorithm>
#include <ctime>
#include <exception>
#include <string>
#include <utility>

#include "api/base/utc.h"
#include "server/base/heap.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr seconds kSweepInterval{30};  // at most: what is kept for a shorter time is swept as often
constexpr minutes kSharedListing{10};  // listing all blobs of shared stores costs many requests
constexpr seconds kUnusedBlobs{600};   // longer than the time from a put() or renew() to the row that refers to it
constexpr seconds kUnusedSharedBlobs{3600};  // the same, with other processes' uploads
constexpr seconds kRecoveryInterval{5};
constexpr std::chrono::hours kBetweenLines{1};

bool due(std::chrono::steady_clock::time_point& next, milliseconds interval) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next) return false;
  next = now + interval;
  return true;
}

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
  const auto origin = store_errors_.noted(stores_.jobs.origin());
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
  const auto known = store_errors_.noted(stores_.jobs.known_blobs());
  if (!known) return true;
  const auto unknown = store_errors_.noted(stores_.blobs.count_unused(*known, older_than));
  return !unknown || unknown->number >= kMostUnknown;
}

void SweepGuard::say(const store::UnusedBlobs& unused, store::TimePoint until, const std::string& why) {
  const milliseconds uptime = uptime_();
  if (next_line_ && uptime < *next_line_) return;
  next_line_ = uptime + kBetweenLines;
  log_event("sweep", std::to_string(unused.number) + " stored files are unknown to the database; " + why +
                         " They are removed after " + api::to_utc_ms(until));
}

// What is thrown is of one round: the next tick tries again.
void Upkeep::tick() try {
  if (stores_.maps) stores_.maps->give_way();
  const bool on_duty = stores_.jobs.on_duty();
  const milliseconds quarter_lease(settings_.lease_ms / 4);
  const bool recovery = stores_.shared && on_duty;
  if (recovery && due(next_recovery_, std::min<milliseconds>(kRecoveryInterval, quarter_lease))) recover();
  unneeded_.remove_some();
  const bool steady = guard_.clock_is_steady();
  if (due(next_sweep_, sweep_interval())) {
    if (on_duty && steady) sweep_rows();
    release_free_memory();
  }
  if (due(next_listing_, stores_.shared ? milliseconds(kSharedListing) : kSweepInterval)) {
    if (stores_.maps) sweep_maps();
    if (on_duty && steady) sweep_blobs();
  }
} catch (const std::exception& error) {
  log_event("store", std::string("a sweep failed and will be repeated: ") + error.what());
}

store::Moment Upkeep::moment() const { return stores_.jobs.moment(seconds(settings_.result_ttl_s)); }

milliseconds Upkeep::sweep_interval() const {
  return std::min({kSweepInterval, seconds(settings_.result_ttl_s), seconds(settings_.mesh_ttl_s)});
}

void Upkeep::recover() {
  store_errors_.note(
      stores_.jobs.recover(std::nullopt, "its worker sent no heartbeat before its lease expired", moment()));
}

void Upkeep::sweep_rows() {
  if (stores_.batches) {
    store_errors_.note(stores_.batches->sweep_batches(stores_.jobs.time() - seconds(settings_.result_ttl_s)));
  }
  store_errors_.note(stores_.jobs.sweep_jobs(moment(), settings_.max_kept_results));
  const auto expired = store_errors_.noted(stores_.meshes.sweep_meshes(stores_.jobs.time()));
  if (!expired) return;
  for (const store::BlobKey& mesh : *expired) unneeded_.add(mesh);
}

void Upkeep::sweep_maps() {
  bool answers = true;
  stores_.maps->sweep([&](const store::JobKey& key) {
    if (!answers) return true;
    const auto row = stores_.jobs.get(key);
    answers = row.ok();
    return !row || *row;
  });
}

void Upkeep::sweep_blobs() {
  const seconds age = stores_.shared ? kUnusedSharedBlobs : kUnusedBlobs;
  const auto used = store_errors_.noted(stores_.jobs.used_blobs());
  if (!used) return;
  const auto unused = store_errors_.noted(stores_.blobs.count_unused(*used, age));
  if (unused && guard_.may_remove(*unused, age)) store_errors_.note(stores_.blobs.remove_unused(*used, age));
}

}  // namespace meshgauge::server
