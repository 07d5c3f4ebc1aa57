// Handlers of /v1/comparisons and the paths below it, and of /v1/options.
//
// POST: admit -> receive -> parse -> submit -> wait -> respond. server/jobs runs what is submitted.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "api/options/request.h"
#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/http/upload.h"
#include "server/jobs/jobs.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class Comparisons {
 public:
  // Borrows all but the first. `uploads`: the byte budget of all uploads of the service.
  Comparisons(const Settings& settings, Jobs& jobs, const Stores& stores, Access& access, ByteBudget& uploads);

  // Each may throw: out of memory.
  void create(Exchange& exchange);
  void get(Exchange& exchange);
  void cancel(Exchange& exchange);
  void remove(Exchange& exchange);
  void events(Exchange& exchange);
  // Answers a POST that finds no place, from its head alone. Never blocks.
  void refuse(Exchange& exchange) const;

  void refuse_new() { draining_.store(true); }  // answers every POST with shutting-down from now on
  bool refusing() const { return draining_.load(); }
  std::uint64_t watcher_count() const { return watchers_.taken(); }
  ConnectionLimit& watchers() { return watchers_; }

 private:
  struct Post;
  struct Waiting;
  // When the POST began, and whether its comparison is durable.
  struct Terms {
    Clock::time_point since = Clock::now();
    bool durable = false;
  };

  static void add_headers(Exchange& exchange, const JobView& job, const Terms& terms);

  using Refusal = std::optional<api::Problem>;

  void receive(Exchange& exchange, const std::shared_ptr<Post>& post);
  void refuse_body(Exchange& exchange, const api::Problem& problem) const;
  Refusal parse(Exchange& exchange, Post& post);
  static void take_form(Post& post);
  Refusal parse_ids(const std::string& owner, Post& post);
  std::optional<api::Problem> open_mesh(const std::string& owner, const std::string& part, MeshSource& source);
  void admit(Exchange& exchange, const std::shared_ptr<Post>& post);
  void repeat(Exchange& exchange, const std::shared_ptr<Post>& post);
  bool repeat_if_known(Exchange& exchange, const std::shared_ptr<Post>& post);
  void submit(Exchange& exchange, Post& post);
  void follow(Exchange& exchange, const Jobs::Submitted& submitted, const Post& post);
  void wait(Exchange& exchange, const std::shared_ptr<LiveJob>& job, const Post& post);
  std::optional<Clock::time_point> look(Exchange& exchange, Waiting& waiting);
  Clock::time_point next_look(const Waiting& waiting) const;
  void follow_events(Exchange& exchange, const std::shared_ptr<LiveJob>& job, const std::shared_ptr<const void>& place);
  void accept(Exchange& exchange, const JobView& job, const Terms& terms) const;
  void respond(Exchange& exchange, const JobView& job, const Terms& terms) const;

  const Settings settings_;
  Jobs& jobs_;
  const Stores stores_;
  Access& access_;
  ByteBudget& uploads_;
  std::atomic<bool> draining_{false};
  ConnectionLimit watchers_;  // clients that follow events, or wait with Prefer: wait
};

// POST /v1/options: reads the options of a comparison before any mesh is sent. Answers with the options as they are
// understood, written in one way, or with all mistakes.
void read_options(Exchange& exchange, const Settings& settings);

}  // namespace meshgauge::server
