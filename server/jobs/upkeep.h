// Periodic work on the stores: removes expired rows, blobs and maps, and requeues jobs of dead workers. Of processes
// that share their stores only the one on duty does it (JobStore::on_duty()).
#pragma once

#include <chrono>
#include <utility>

#include "server/jobs/sweep_guard.h"
#include "server/measure/kept_blobs.h"
#include "server/measure/store_errors.h"
#include "server/measure/stores.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class Upkeep {
 public:
  // Borrows all but the first.
  Upkeep(const Settings& settings, Stores stores, StoreErrors& store_errors, SweepGuard::Uptime uptime = system_uptime)
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
