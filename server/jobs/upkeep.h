// What is done for the stores from time to time: what is too old goes, and what lost its worker goes back to the queue.
// Of processes that share their stores the one that is on duty does it.
#pragma once

#include <chrono>

#include "server/jobs/store_errors.h"
#include "server/jobs/stores.h"
#include "server/settings.h"

namespace meshgauge::server {

class Upkeep {
 public:
  // Borrows all but the first.
  Upkeep(const Settings& settings, Stores stores, StoreErrors& store_errors)
      : settings_(settings), stores_(stores), store_errors_(store_errors) {}

  void tick();  // does what is due; once a second, by one thread

 private:
  using Clock = std::chrono::steady_clock;

  void recover();
  void sweep_rows();
  void sweep_maps();
  void sweep_blobs();
  store::Moment moment() const;

  const Settings settings_;
  const Stores stores_;
  StoreErrors& store_errors_;
  // At once: a service that is killed again and again is to sweep as well.
  Clock::time_point next_recovery_ = Clock::now();
  Clock::time_point next_sweep_ = Clock::now();
  Clock::time_point next_listing_ = Clock::now();
};

}  // namespace meshgauge::server
