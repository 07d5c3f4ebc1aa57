// Handlers of GET /v1/meshes, /v1/comparisons and /v1/batches: what a key has stored, newest first, and how much of its
// limits that is.
//
// Only for keys: without them all clients are one owner, and the ids, which cannot be guessed, are what keeps one
// client's results from the next.
#pragma once

#include <string>

#include "api/result/json_of.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/measure/stores.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class Listings {
 public:
  // Borrows all but the first. Precondition: stores.listings is not null.
  Listings(const Settings& settings, const Stores& stores, Access& access);

  // Each may throw: out of memory.
  void meshes(Exchange& exchange);
  void comparisons(Exchange& exchange);
  void batches(Exchange& exchange);

 private:
  template <class Row>
  using List = Result<std::vector<Row>> (store::Listings::*)(const store::Page& page);
  template <class Row>
  void list(Exchange& exchange, const char* name, List<Row> of,
            Result<api::Json> (Listings::*used)(const std::string&));

  Result<api::Json> meshes_used(const std::string& owner);
  Result<api::Json> comparisons_used(const std::string& owner);
  Result<api::Json> batches_used(const std::string& owner);
  Allowance allowance_of(const std::string& owner) const;

  const Settings settings_;
  const Stores stores_;
  Access& access_;
};

}  // namespace meshgauge::server
