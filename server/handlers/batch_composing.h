// From what a client asked for to the rows of a batch.
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

// Of the stored meshes that the batch names, each once.
std::vector<std::string> stored_ids(const api::BatchRequest& request);

// Says of up to 100 meshes that are not stored where they are named; nothing when all are.
std::optional<api::Problem> find_unknown(const api::BatchRequest& request, const std::vector<store::MeshRow>& known);

struct BatchHead {
  store::JobKey key;
  std::string idempotency_key;
  std::string trace;
  store::TimePoint created{};
  store::TimePoint expires_if_never_run{};
};

// `known` may lack some, when the batch was accepted before: then it is only compared.
store::NewBatch compose(const BatchHead& head, const api::BatchRequest& request,
                        const std::map<std::string, BatchFile>& files, const std::vector<store::MeshRow>& known);

}  // namespace meshgauge::server
