#include "server/jobs/upkeep.h"

#include <algorithm>
#include <exception>
#include <string>

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

bool due(std::chrono::steady_clock::time_point& next, milliseconds interval) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next) return false;
  next = now + interval;
  return true;
}

}  // namespace

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

store::Moment Upkeep::moment() const {
  const auto now = stores_.jobs.time();
  return {now, now + seconds(settings_.result_ttl_s)};
}

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
  const auto expired = stores_.meshes.sweep_meshes(stores_.jobs.time());
  store_errors_.note(expired);
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
  const auto used = stores_.jobs.used_blobs();
  store_errors_.note(used);
  if (!used) return;
  const auto unused = stores_.blobs.count_unused(*used, age);
  store_errors_.note(unused);
  if (unused && guard_.may_remove(*unused, age)) store_errors_.note(stores_.blobs.remove_unused(*used, age));
}

}  // namespace meshgauge::server
