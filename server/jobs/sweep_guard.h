// Decides whether a sweep may remove what is expired or unknown. A clock that jumped and a database that was lost make
// everything look so; both wait for a day, with a line in the log. One thread.
#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "server/measure/store_errors.h"
#include "server/measure/stores.h"

namespace meshgauge::server {

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

std::chrono::milliseconds system_uptime();  // since the start of the machine, its sleep included

}  // namespace meshgauge::server
