// /v1/comparisons and what is below it.
//
// POST: admit -> receive -> parse -> submit -> wait -> respond. What happens between the last three is server/jobs.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "api/request.h"
#include "server/exchange.h"
#include "server/jobs/jobs.h"
#include "server/prefer.h"
#include "server/settings.h"
#include "server/upload.h"

namespace meshgauge::server {

class Comparisons {
 public:
  // Borrows both.
  Comparisons(const Settings& settings, Jobs& jobs, store::MeshIndex& meshes, store::BlobStore& blobs);

  // Each may throw: out of memory.
  void create(Exchange& exchange);
  void get(Exchange& exchange);
  void remove(Exchange& exchange);
  void events(Exchange& exchange);

  void refuse_new() { draining_.store(true); }

 private:
  struct Asked;
  class Seat;

  std::optional<api::Problem> receive(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> receive_form(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> receive_ids(Exchange& exchange, Asked& asked);
  std::optional<api::Problem> open_mesh(const std::string& owner, const std::string& part, const std::string& id,
                                        MeshSource& source);
  void wait(Exchange& exchange, LiveJob& job, const Asked& asked);
  void respond(Exchange& exchange, const JobView& job, const Asked& asked) const;

  const Settings settings_;
  Jobs& jobs_;
  store::MeshIndex& meshes_;
  store::BlobStore& blobs_;
  ByteBudget budget_;
  std::atomic<bool> draining_{false};
  std::atomic<std::size_t> seats_{0};
};

}  // namespace meshgauge::server
