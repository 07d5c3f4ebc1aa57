// Makes the rows of a batch from its parsed request.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "api/batch_request.h"
#include "api/problem.h"
#include "server/handlers/batch_receiver.h"
#include "server/store/batch_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server {

// Returns the ids of the stored meshes that the batch names, each once.
std::vector<std::string> stored_ids(const api::BatchRequest& request);

// Returns a problem that lists up to 100 places where the request names a mesh that is not in `known`; nullopt: all
// are.
std::optional<api::Problem> find_unknown(const api::BatchRequest& request, const std::vector<store::MeshRow>& known);

struct BatchHead {
  store::JobKey key;
  std::string client;  // NewJob::client
  std::string idempotency_key;
  std::string trace;
  store::TimePoint created{};
  store::TimePoint expires_if_never_run{};
};

// `files`: the uploaded files, by field name. `known`: rows of the stored meshes; it may lack some if the batch repeats
// an Idempotency-Key, since it is then only compared with the stored batch.
store::NewBatch compose(const BatchHead& head, const api::BatchRequest& request,
                        const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known);

}  // namespace meshgauge::server
