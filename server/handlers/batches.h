// Handlers of /v1/batches and the paths below it: many comparisons in one request.
//
// POST: admit -> receive (manifest, files) -> look up meshes -> compose -> insert -> 202. Workers then claim the jobs.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/access/access.h"
#include "server/handlers/batch_receiver.h"
#include "server/http/connection_limit.h"
#include "server/http/exchange.h"
#include "server/http/upload.h"
#include "server/jobs/jobs.h"
#include "server/settings/settings.h"
#include "server/store/batch_store.h"

namespace meshgauge::server {

class Batches {
 public:
  // Limits per owner, beyond which new batches are refused: kMostUnended * max_batch_pairs comparisons queued or
  // running in batches, and kMostBatches unfinished batches (each claim looks at all of them).
  static constexpr std::uint64_t kMostUnended = 10;
  static constexpr std::uint64_t kMostBatches = 200;

  // Borrows all but the first. Precondition: stores.batches is not null. `jobs`: when they stop, event streams and
  // waits end, and clients reconnect elsewhere. `watchers`: limits clients that occupy a connection for long.
  Batches(const Settings& settings, const Jobs& jobs, const Stores& stores, Access& access, ByteBudget& uploads,
          ConnectionLimit& watchers);

  // Each may throw: out of memory. `draining`: refuse new batches.
  void create(Exchange& exchange, bool draining);
  void get(Exchange& exchange);
  void cancel(Exchange& exchange);
  void remove(Exchange& exchange);
  void events(Exchange& exchange);
  void results(Exchange& exchange);
  void junit(Exchange& exchange);

 private:
  Result<bool> is_known(const std::string& owner, const std::string& idempotency_key);
  void end(Exchange& exchange, const store::JobKey& key);  // cancels what has not ended
  std::optional<api::Problem> admit(const std::string& owner);
  void insert(Exchange& exchange, BatchReceiver& receiver, bool repeats);
  api::Problem problem_of_removed_mesh(const std::string& owner, const api::BatchRequest& request);
  std::optional<store::Batch> find(Exchange& exchange);  // nullopt: the exchange is answered
  Result<std::string> document(const store::Batch& batch);
  void send(Exchange& exchange, const store::Batch& batch, int status);
  std::chrono::milliseconds look_interval(const store::Batch& batch) const;
  void throw_if_deleted(const store::JobKey& key);
  void stream_rows(Exchange& exchange, std::string head, std::function<std::string(const store::BatchRow&)> line,
                   std::string tail);

  const Settings settings_;
  const Jobs& jobs_;
  const Stores stores_;
  store::BatchStore& batches_;
  Access& access_;
  ByteBudget& uploads_;
  ConnectionLimit& watchers_;
  const std::chrono::seconds kept_;
};

}  // namespace meshgauge::server
