// Handlers of /v1/comparisons and the paths below it.
//
// POST: admit -> receive -> parse -> submit -> wait -> respond. server/jobs runs what is submitted.
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
  // Borrows all but the first. `uploads`: the byte budget of all uploads of the service.
  Comparisons(const Settings& settings, Jobs& jobs, Stores stores, Access& access, ByteBudget& uploads);

  // Each may throw: out of memory.
  void create(Exchange& exchange);
  void get(Exchange& exchange);
  void remove(Exchange& exchange);
  void events(Exchange& exchange);

  void refuse_new() { draining_.store(true); }  // answers every POST with shutting-down from now on
  bool refusing() const { return draining_.load(); }
  std::uint64_t watcher_count() const { return watchers_.taken(); }
  ConnectionLimit& watchers() { return watchers_; }

 private:
  struct Post;

  std::optional<api::Problem> receive(Exchange& exchange, Post& post);
  std::optional<api::Problem> receive_form(Exchange& exchange, Post& post);
  std::optional<api::Problem> receive_ids(Exchange& exchange, Post& post);
  std::optional<api::Problem> open_mesh(const std::string& owner, const std::string& part, MeshSource& source);
  void admit(Exchange& exchange, Post& post);
  void repeat(Exchange& exchange, Post& post);
  bool repeat_if_known(Exchange& exchange, Post& post);
  void follow(Exchange& exchange, const Jobs::Submitted& submitted, const Post& post);
  void wait(Exchange& exchange, const std::shared_ptr<LiveJob>& waited, const Post& post);
  void add_headers(Exchange& exchange, const JobView& job, const Post& post) const;
  void accept(Exchange& exchange, const JobView& job, const Post& post) const;
  void respond(Exchange& exchange, const JobView& job, const Post& post) const;

  const Settings settings_;
  Jobs& jobs_;
  const Stores stores_;
  Access& access_;
  ByteBudget& uploads_;
  std::atomic<bool> draining_{false};
  ConnectionLimit watchers_;  // clients that follow events, or wait with Prefer: wait
};

}  // namespace meshgauge::server
