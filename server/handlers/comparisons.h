// /v1/comparisons and what is below it.
//
// POST: admit -> receive -> parse -> submit -> wait -> respond. What happens between the last three is server/jobs.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "api/request.h"
#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/http/prefer.h"
#include "server/http/upload.h"
#include "server/jobs/jobs.h"
#include "server/settings.h"

namespace meshgauge::server {

class Comparisons {
 public:
  // Borrows all but the first. `uploads`: shared by all that receive bytes.
  Comparisons(const Settings& settings, Jobs& jobs, Stores stores, Access& access, ByteBudget& uploads);

  // Each may throw: out of memory.
  void create(Exchange& exchange);
  void get(Exchange& exchange);
  void remove(Exchange& exchange);
  void events(Exchange& exchange);

  void refuse_new() { draining_.store(true); }
  bool refusing() const { return draining_.load(); }
  std::uint64_t watcher_count() const { return watchers_.taken(); }
  ConnectionLimit& watchers() { return watchers_; }

 private:
  struct Asked;

  std::optional<api::Problem> receive(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> receive_form(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> receive_ids(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> open_mesh(const std::string& owner, const std::string& part, MeshSource& source);
  void admit(Exchange& exchange, Asked& asked);
  void repeat(Exchange& exchange, Asked& asked);
  bool repeat_if_known(Exchange& exchange, Asked& asked);
  void follow(Exchange& exchange, const Jobs::Submitted& submitted, const Asked& asked);
  void wait(Exchange& exchange, const std::shared_ptr<LiveJob>& waited, const Asked& asked);
  void add_headers(Exchange& exchange, const JobView& job, const Asked& asked) const;
  void accept(Exchange& exchange, const JobView& job, const Asked& asked) const;
  void respond(Exchange& exchange, const JobView& job, const Asked& asked) const;

  const Settings settings_;
  Jobs& jobs_;
  const Stores stores_;
  Access& access_;
  ByteBudget& uploads_;
  std::atomic<bool> draining_{false};
  ConnectionLimit watchers_;  // of clients that watch, or wait as long as they prefer
};

}  // namespace meshgauge::server
