// Periodic work on the stores: removes expired rows, blobs and maps, and requeues jobs of dead workers. Of processes
// that share their stores only the one on duty does it (JobStore::on_duty()), and none removes what only looks expired
// or unknown.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "server/measure/kept_blobs.h"
#include "server/measure/stores.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

std::chrono::milliseconds system_uptime();  // since the start of the machine, its sleep included

// Decides whether a sweep may remove what is expired or unknown. A clock that jumped and a database that was lost make
// everything look so; both wait for a day, with a line in the log. One thread.
class SweepGuard {
 public:
  using Uptime = std::function<std::chrono::milliseconds()>;  // a clock that is never set

  static constexpr std::chrono::hours kGrace{24};
  static constexpr std::chrono::hours kJump{1};       // a larger one of the stores' clock pauses all sweeps
  static constexpr std::uint64_t kMostUnknown = 100;  // blobs; crashes leave fewer

  SweepGuard(const Stores& stores, StoreErrors& store_errors, Uptime uptime);

  // false: the clock has jumped within the last day, and has not come back. The first jump counts from the
  // construction.
  bool clock_is_steady();

  // `unused`: what a sweep would remove. false: it may be what a database knew that was lost: some is older than the
  // database, which is not a day old, or no row knows much of it, and that was first found less than a day ago.
  bool may_remove(const store::UnusedBlobs& unused, std::chrono::seconds older_than);

 private:
  std::chrono::milliseconds offset() const;  // of the stores' clock to the other one
  bool has_grace(const store::UnusedBlobs& unused, std::chrono::seconds older_than, const store::Origin& origin);
  bool are_unknown(std::chrono::seconds older_than);
  void say(const store::UnusedBlobs& unused, store::TimePoint until, const std::string& why);

  const Stores stores_;
  StoreErrors& store_errors_;
  const Uptime uptime_;
  std::chrono::milliseconds offset_;                    // while the clock was right
  std::optional<std::chrono::milliseconds> jumped_;     // uptime when the clock was found to have jumped
  std::optional<std::chrono::milliseconds> next_line_;  // uptime
};

class Upkeep {
 public:
  // Borrows all but the first.
  Upkeep(const Settings& settings, const Stores& stores, StoreErrors& store_errors,
         SweepGuard::Uptime uptime = system_uptime)
      : settings_(settings),
        stores_(stores),
        store_errors_(store_errors),
        unneeded_(stores, store_errors),
        guard_(stores, store_errors, std::move(uptime)) {}

  void tick();  // does what is due. Call it once a second, on one thread; blocks for the stores; throws nothing

  // Soon removes the blob unless something refers to it. Any thread.
  void remove_unless_used(store::BlobKey blob) { unneeded_.add(std::move(blob)); }

 private:
  using Clock = std::chrono::steady_clock;

  void recover();
  void sweep_rows();
  void sweep_maps();
  void sweep_blobs();
  std::chrono::milliseconds sweep_interval() const;
  store::Moment moment() const;

  const Settings settings_;
  const Stores stores_;
  StoreErrors& store_errors_;
  UnneededBlobs unneeded_;
  SweepGuard guard_;
  // The first tick does everything: a service that is killed again and again must sweep, too.
  Clock::time_point next_recovery_ = Clock::now();
  Clock::time_point next_sweep_ = Clock::now();
  Clock::time_point next_listing_ = Clock::now();
};

}  // namespace meshgauge::server
